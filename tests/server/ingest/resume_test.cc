// A server that is killed, again and again: a robot's session leaves the same behind, bit for bit,
// as if it had not been.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "core/codec/payload_builder.h"
#include "server/ingest/session_worker.h"
#include "tests/floam/room.h"
#include "tests/server/ingest/killed_session.h"

namespace isthmus::ingest {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::SentScan;
using testing::Session;
using testing::SmallSubmaps;
using testing::Store;

SentScan MakeTurn(int index) {
  const Scan scan = MakeScan(floam::testing::FurnishedRoom(), floam::testing::Loop(1.2),
                             floam::testing::Sensor(), index);
  return {codec::MakePayload(scan), scan.end_stamp_ns};
}

PointPayload Blank() { return codec::MakePayload(std::vector<ScanPoint>(64), true, true); }

// A loop with what happens: blank scans, scans that never came, one out of order, a clock that is
// set back.
std::vector<SentScan> TroubledDrive() {
  std::vector<SentScan> turns;
  for (int k = 0; k < 110; ++k) {
    if (k == 30 || k == 31) continue;
    turns.push_back(MakeTurn(k));
    if (k == 15 || (k >= 60 && k < 64)) turns.back().payload = Blank();
    if (k == 45) turns.back().end_stamp_ns -= 500'000'000;
    if (k >= 80) turns.back().end_stamp_ns -= 3'600'000'000'000;
  }
  return turns;
}

TEST(Resume, LeavesTheSameBehindHoweverOftenItWasKilled) {
  const std::vector<SentScan> turns = TroubledDrive();
  Store undisturbed;
  Session calm(&undisturbed, SmallSubmaps());
  for (const SentScan& turn : turns) calm.Send(turn.payload, turn.end_stamp_ns);
  ASSERT_TRUE(calm.worker().Finish().ok());
  ASSERT_GE(undisturbed.submaps().size(), 6u);

  std::mt19937 random(4);
  for (const size_t kills : {size_t{1}, size_t{6}, turns.size()}) {
    Store store;
    Session session(&store, SmallSubmaps());
    std::set<size_t> moments;
    while (moments.size() < kills) moments.insert(random() % turns.size());
    for (size_t k = 0; k < turns.size(); ++k) {
      session.Send(turns[k].payload, turns[k].end_stamp_ns);
      if (moments.count(k) > 0) session.Restart();
    }
    ASSERT_TRUE(session.worker().Finish().ok());
    EXPECT_EQ(store.Contents(), undisturbed.Contents()) << kills;
    EXPECT_EQ(session.worker().Status().durable_sequence, turns.size());
    EXPECT_THAT(session.worker().Status().input, Not(HasSubstr("resumed")));
  }
}

// A submap that was stored without a checkpoint is made again, but not stored again.
TEST(Resume, WhatIsStoredBeyondTheCheckpointIsNotStoredTwice) {
  Store undisturbed, store;
  Session calm(&undisturbed, SmallSubmaps()), session(&store, SmallSubmaps());
  std::optional<SessionCheckpoint> older;
  for (int k = 0; k < 70; ++k) {
    const SentScan turn = MakeTurn(k);
    calm.Send(turn.payload, turn.end_stamp_ns);
    session.Send(turn.payload, turn.end_stamp_ns);
    if (k == 30) older = store.checkpoint;
    if (k != 50) continue;
    ASSERT_EQ(store.submaps().size(), 2u);
    ASSERT_LT(older->sequence, store.submaps()[1]->first_sequence + 10);
    store.checkpoint = older;
    session.KeepAll();
    session.Restart();
  }
  ASSERT_TRUE(calm.worker().Finish().ok());
  ASSERT_TRUE(session.worker().Finish().ok());
  EXPECT_EQ(store.Contents(), undisturbed.Contents());
}

TEST(Resume, GoesOnWhereAGracefulEndStopped) {
  Store store;
  Session session(&store, SmallSubmaps());
  for (int k = 0; k < 30; ++k) session.Send(MakeTurn(k).payload, MakeTurn(k).end_stamp_ns);
  ASSERT_TRUE(session.worker().Finish().ok());
  EXPECT_EQ(store.checkpoint->sequence, 30u);
  EXPECT_EQ(store.checkpoint->durable_sequence, 30u);
  const int checkpoints = store.checkpoints;
  ASSERT_TRUE(session.worker().Finish().ok());
  EXPECT_EQ(store.checkpoints, checkpoints);
  session.Restart();
  EXPECT_EQ(session.worker().Status().last_sequence, 30u);
  const ScanAck ack = session.Send(MakeTurn(30).payload, MakeTurn(30).end_stamp_ns);
  EXPECT_EQ(ack.tracking, Tracking::kOk);
  // The way between the submaps before and after is known, as if nothing had been in between.
  ASSERT_TRUE(session.worker().Finish().ok());
  EXPECT_GT(store.submaps().back()->drift_covariance.trace(), 0);
}

TEST(Resume, ARobotThatStandsBlindIsDurableToo) {
  Store store;
  SessionWorker::Options options;
  options.submap.cut_scans = 20;
  Session session(&store, options);
  for (int k = 0; k < 10; ++k) session.Send(MakeTurn(k).payload, MakeTurn(k).end_stamp_ns);
  ScanAck ack;
  for (int k = 10; k < 510; ++k) {
    ack = session.Send(Blank(), MakeTurn(9).end_stamp_ns + (k - 9) * int64_t{100'000'000});
    EXPECT_GE(ack.durable_sequence + options.checkpoint_scans + 20, ack.sequence);
  }
  EXPECT_GE(ack.durable_sequence, 400u);
  EXPECT_EQ(store.submaps().size(), 1u);
  session.Restart();
  EXPECT_EQ(session.worker().Status().durable_sequence, ack.durable_sequence);
}

TEST(Resume, GoesOnFromTheSubmapsWhereTheCheckpointIsDamaged) {
  for (const int damage : {0, 1, 2}) {
    SCOPED_TRACE(damage);
    Store store;
    Session session(&store, SmallSubmaps());
    for (int k = 0; k < 50; ++k) session.Send(MakeTurn(k).payload, MakeTurn(k).end_stamp_ns);
    ASSERT_EQ(store.submaps().size(), 2u);
    ASSERT_GT(store.checkpoint->sequence, 40u);
    if (damage == 0) store.checkpoint->state.reset();
    if (damage == 1) (*store.checkpoint->state)[store.checkpoint->state->size() / 2] ^= 4;
    if (damage == 2) store.checkpoint->state->resize(3);
    session.Restart();
    EXPECT_THAT(session.worker().Status().input, HasSubstr("resumed from submaps"));
    for (int k = 50; k < 70; ++k) {
      const ScanAck ack = session.Send(MakeTurn(k).payload, MakeTurn(k).end_stamp_ns);
      EXPECT_EQ(ack.tracking, Tracking::kOk) << k;
      const Pose truth = EndPose(floam::testing::Loop(1.2), floam::testing::Sensor(), 0).Inverse() *
                         EndPose(floam::testing::Loop(1.2), floam::testing::Sensor(), k);
      EXPECT_LT((ack.T_odom_sensor->translation() - truth.translation()).norm(), 0.1) << k;
    }
    EXPECT_THAT(session.worker().Status().input, HasSubstr("resumed from submaps"));
    ASSERT_TRUE(session.worker().Finish().ok());
  }
}

TEST(Resume, NothingIsDurableWhileTheDiskIsFull) {
  Store store;
  Session session(&store, SmallSubmaps());
  for (int k = 0; k < 10; ++k) session.Send(MakeTurn(k).payload, MakeTurn(k).end_stamp_ns);
  store.is_full = true;
  ScanAck ack;
  int k = 10;
  const uint64_t durable = session.worker().Status().durable_sequence;
  // A checkpoint and a submap wait; then scans are refused.
  for (; k < 20; ++k) {
    ack = session.Send(MakeTurn(k).payload, MakeTurn(k).end_stamp_ns);
    EXPECT_EQ(ack.durable_sequence, durable);
  }
  const SentScan next = MakeTurn(k);
  const auto refused = session.worker().Submit({ack.sequence + 1, next.end_stamp_ns, next.payload});
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted) << refused;
  store.is_full = false;
  for (; k < 50; ++k) ack = session.Send(MakeTurn(k).payload, MakeTurn(k).end_stamp_ns);
  EXPECT_GE(ack.durable_sequence, 40u);
  session.Restart();
  ASSERT_TRUE(session.worker().Finish().ok());
  EXPECT_EQ(session.worker().Status().durable_sequence, 50u);
}

}  // namespace
}  // namespace isthmus::ingest
