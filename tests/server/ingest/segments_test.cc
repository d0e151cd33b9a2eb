// A robot that is not found again goes on in a segment of its own: it is told, the segments are
// kept apart, and a crash changes nothing of it.
#include <absl/cleanup/cleanup.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <random>
#include <set>

#include "core/codec/payload_builder.h"
#include "server/ingest/session_worker.h"
#include "tests/floam/building.h"
#include "tests/server/ingest/killed_session.h"

namespace isthmus::ingest {
namespace {

using floam::testing::EndPose;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::SentScan;
using testing::Session;
using testing::SmallSubmaps;
using testing::Store;

constexpr int kFirst = 45;   // Scans of the room where the session begins ...
constexpr int kSecond = 75;  // ... and of the building that it is carried to.

// From rest, along the axis of the building, slowly.
Pose ThroughOtherBuilding(double time_s) {
  const double moving = std::max(0.0, time_s - 0.5);
  const double along = moving < 1 ? 0.3 * moving * moving : 0.6 * moving - 0.3;
  return Pose::FromXyzRpy(-10 + along, 0.4, 0, 0, 0, 0.3);
}

// Through the furnished room, and then through a building that the session knows nothing of.
std::vector<SentScan> KidnappedDrive() {
  const floam::testing::Sensor sensor;
  std::vector<SentScan> turns;
  for (int k = 0; k < kFirst + kSecond; ++k) {
    const Scan scan =
        k < kFirst
            ? MakeScan(floam::testing::FurnishedRoom(), floam::testing::Loop(1.2), sensor, k)
            : MakeScan(floam::testing::OtherBuilding(), ThroughOtherBuilding, sensor, k - kFirst);
    turns.push_back({codec::MakePayload(scan), 1'000'000'000 + (k + 1) * int64_t{100'000'000}});
  }
  return turns;
}

const std::vector<SentScan>& Turns() {
  static const auto* const turns = new std::vector<SentScan>(KidnappedDrive());
  return *turns;
}

std::vector<ScanAck> SendAll(Session& session) {
  std::vector<ScanAck> acks;
  for (const SentScan& turn : Turns())
    acks.push_back(session.Send(turn.payload, turn.end_stamp_ns));
  return acks;
}

// The index of the first scan in a later segment; past the end if there is none.
size_t FirstOfSecond(const std::vector<ScanAck>& acks) {
  return static_cast<size_t>(
      std::find_if(acks.begin(), acks.end(), [](const ScanAck& ack) { return ack.segment > 1; }) -
      acks.begin());
}

TEST(Segments, TheAckSaysWhichAndPosesOfTheNewOneAreRightInItsOwnFrame) {
  Store store;
  Session session(&store, SmallSubmaps());
  const std::vector<ScanAck> acks = SendAll(session);
  const size_t begin = FirstOfSecond(acks);
  ASSERT_LT(begin, acks.size() - 20);
  EXPECT_GE(begin, kFirst + 15u) << "about two seconds";
  const floam::testing::Sensor sensor;
  const int first_turn = static_cast<int>(begin) - kFirst;
  for (size_t k = 0; k < acks.size(); ++k) {
    SCOPED_TRACE(k);
    const bool is_second = k >= begin;
    EXPECT_EQ(acks[k].segment, is_second ? 2u : 1u);
    EXPECT_EQ(acks[k].segment_session, SessionId(is_second ? "alice-1.2" : "alice-1"));
    EXPECT_EQ(acks[k].tracking, k < kFirst || is_second ? Tracking::kOk : Tracking::kLost);
    EXPECT_EQ(acks[k].lost_since_ns, k < kFirst || is_second ? 0 : Turns()[kFirst].end_stamp_ns);
    if (!is_second) continue;
    const Pose truth = EndPose(ThroughOtherBuilding, sensor, first_turn).Inverse() *
                       EndPose(ThroughOtherBuilding, sensor, static_cast<int>(k) - kFirst);
    EXPECT_LT((acks[k].T_odom_sensor->translation() - truth.translation()).norm(), 0.1);
  }
  EXPECT_TRUE(acks[begin].T_odom_sensor->translation().isZero(1e-9));
  const uint64_t lost = begin - kFirst;
  EXPECT_EQ(acks.back().scans, (ScanCounts{acks.size() - lost, 0, lost, 0}));
}

TEST(Segments, NoSubmapReachesAcrossAndBothCountFromZero) {
  Store store;
  Session session(&store, SmallSubmaps());
  const std::vector<ScanAck> acks = SendAll(session);
  const size_t begin = FirstOfSecond(acks);
  ASSERT_TRUE(session.worker().Finish().ok());
  ASSERT_GE(store.submaps(1).size(), 3u);
  ASSERT_GE(store.submaps(2).size(), 2u);
  for (const auto& submap : store.submaps(1)) EXPECT_LE(submap->last_sequence, 0u + kFirst);
  EXPECT_EQ(store.submaps(2).front()->first_sequence, begin + 1);
  EXPECT_EQ(store.submaps(2).front()->drift_covariance, Matrix6d::Zero()) << "nothing ties it";
  EXPECT_TRUE(store.submaps(2).front()->T_odom_submap.translation().isZero(1e-9));
  EXPECT_EQ(store.trajectory(1).size(), 0u + kFirst);
  EXPECT_EQ(store.trajectory(2).size(), acks.size() - begin);
  EXPECT_EQ(session.worker().Status().durable_sequence, acks.size());
  // No way was gone between the two.
  EXPECT_LT(session.worker().Status().travelled_m, 10);
}

TEST(Segments, AreKnownToTheStoreBeforeTheRobotHearsOfThem) {
  Store store;
  SessionWorker::Options options = SmallSubmaps();
  options.checkpoint_scans = 1000;
  // The disk is busy all the time.
  std::promise<void> disk;
  Executor storing(1);
  storing.Post([busy = disk.get_future().share()] { busy.wait(); });
  const absl::Cleanup free_disk = [&disk] { disk.set_value(); };
  options.storing = &storing;
  Session session(&store, options);
  for (const SentScan& turn : Turns()) {
    const ScanAck ack = session.Send(turn.payload, turn.end_stamp_ns);
    if (ack.segment == 1) continue;
    EXPECT_TRUE(store.has_segment(2));
    EXPECT_EQ(ack.durable_sequence, ack.sequence - 1) << "all before it is safe";
    return;
  }
  FAIL() << "no segment was begun";
}

TEST(Segments, TheLogSaysWhenItGotLostAndWhereItGoesOn) {
  Store store;
  Session session(&store, SmallSubmaps());
  SendAll(session);
  EXPECT_THAT(session.told,
              ElementsAre(HasSubstr("session alice-1 is lost since scan 46, in segment 1"),
                          HasSubstr("session alice-1 goes on in segment 2 (alice-1.2) from scan")));
}

TEST(Segments, AreTheSameHoweverOftenTheServerWasKilled) {
  Store undisturbed;
  Session calm(&undisturbed, SmallSubmaps());
  const std::vector<ScanAck> expected = SendAll(calm);
  ASSERT_TRUE(calm.worker().Finish().ok());
  const size_t begin = FirstOfSecond(expected), count = expected.size();
  std::mt19937 random(4);
  std::set<size_t> some, second_begins = {begin - 1, begin, begin + 1}, many;
  while (some.size() < 8) some.insert(random() % count);
  for (size_t k = random() % 3; k < count; k += 3) many.insert(k);
  for (const std::set<size_t>& moments : {some, second_begins, many}) {
    Store store;
    Session session(&store, SmallSubmaps());
    for (size_t k = 0; k < count; ++k) {
      const ScanAck ack = session.Send(Turns()[k].payload, Turns()[k].end_stamp_ns);
      EXPECT_EQ(ack.segment, expected[k].segment);
      EXPECT_EQ(ack.scans, expected[k].scans);
      EXPECT_EQ(ack.lost_since_ns, expected[k].lost_since_ns);
      if (moments.contains(k)) session.Restart();
    }
    ASSERT_TRUE(session.worker().Finish().ok());
    EXPECT_EQ(store.Contents(), undisturbed.Contents());
    EXPECT_EQ(session.worker().Status().scans, expected.back().scans);
  }
}

// If the checkpoint is damaged and nothing of the last segment is stored, its frame is gone.
TEST(Segments, AFrameThatNothingIsLeftOfIsNotGoneOnIn) {
  Store store;
  SessionWorker::Options options;
  Session session(&store, options);
  size_t k = 0;
  ScanAck ack;
  for (; ack.segment == 1 && k < Turns().size(); ++k) {
    ack = session.Send(Turns()[k].payload, Turns()[k].end_stamp_ns);
  }
  ASSERT_EQ(ack.segment, 2u);
  ASSERT_TRUE(store.submaps(2).empty());
  store.checkpoint->state.reset();
  session.Restart();
  ack = session.Send(Turns()[k].payload, Turns()[k].end_stamp_ns);
  EXPECT_EQ(ack.segment, 3u);
  EXPECT_TRUE(store.has_segment(3));
  ASSERT_TRUE(session.worker().Finish().ok());
  EXPECT_EQ(store.submaps(3).front()->id, (SubmapId{SessionId("alice-1.3"), 0}));
}

// A session goes on in its last segment, whatever its number, if that has submaps.
TEST(Segments, GoOnFromTheirOwnSubmapsWhereTheCheckpointIsDamaged) {
  Store store;
  Session session(&store, SmallSubmaps());
  const std::vector<ScanAck> acks = SendAll(session);
  ASSERT_FALSE(store.submaps(2).empty());
  store.checkpoint->state.reset();
  session.Restart();
  EXPECT_THAT(session.worker().Status().input, HasSubstr("resumed from submaps"));
  const int next = static_cast<int>(Turns().size());
  const floam::testing::Sensor sensor;
  const Scan scan =
      MakeScan(floam::testing::OtherBuilding(), ThroughOtherBuilding, sensor, next - kFirst);
  const ScanAck ack =
      session.Send(codec::MakePayload(scan), Turns().back().end_stamp_ns + 100'000'000);
  EXPECT_EQ(ack.segment, 2u);
  EXPECT_EQ(ack.tracking, Tracking::kOk);
  const int first_turn = static_cast<int>(FirstOfSecond(acks)) - kFirst;
  const Pose truth = EndPose(ThroughOtherBuilding, sensor, first_turn).Inverse() *
                     EndPose(ThroughOtherBuilding, sensor, next - kFirst);
  EXPECT_LT((ack.T_odom_sensor->translation() - truth.translation()).norm(), 0.1);
}

}  // namespace
}  // namespace isthmus::ingest
