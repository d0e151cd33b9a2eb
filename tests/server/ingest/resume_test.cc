// A server that is killed, again and again: what a robot's session leaves behind is the same, bit
// for bit, as if it had not been.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "core/codec/payload_builder.h"
#include "core/executor.h"
#include "floam/state_codec.h"
#include "floam/unfinished_submap.h"
#include "server/ingest/session_worker.h"
#include "tests/floam/room.h"

namespace isthmus::ingest {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// What is durable: it survives the worker.
class Store {
 public:
  absl::Status Persist(const Stretch& stretch) {
    if (is_full) return absl::ResourceExhaustedError("the disk is full");
    if (stretch.submap != nullptr) {
      EXPECT_EQ(stretch.submap->id.index, submaps_.size()) << "twice, or one is missing";
      submaps_.push_back(stretch.submap);
    }
    for (const TrajectoryEntry& entry : stretch.trajectory) {
      EXPECT_TRUE(trajectory_.emplace(entry.sequence, entry).second) << entry.sequence;
    }
    if (stretch.checkpoint) {
      EXPECT_TRUE(stretch.checkpoint->state.has_value());
      checkpoint = stretch.checkpoint;
      ++checkpoints;
    }
    return absl::OkStatus();
  }

  ResumePoint Resume() const {
    ResumePoint resume;
    resume.checkpoint = checkpoint;
    resume.next_index = static_cast<uint32_t>(submaps_.size());
    if (!submaps_.empty()) resume.last_sequence = submaps_.back()->last_sequence;
    resume.for_each_submap = [this](const std::function<void(const Submap&)>& visit) {
      for (const auto& submap : submaps_) visit(*submap);
    };
    for (const auto& [sequence, entry] : trajectory_) resume.trajectory.push_back(entry);
    return resume;
  }

  // All of it, as bytes.
  std::string Contents() const {
    floam::StateWriter out;
    for (const auto& submap : submaps_) {
      out(submap->id.index);
      floam::WriteUnfinished(*submap, out);
    }
    for (const auto& [sequence, entry] : trajectory_) {
      out(sequence, entry.stamp_ns, entry.T_odom_sensor, entry.submap_index);
    }
    return out.Take();
  }
  const std::vector<std::shared_ptr<const Submap>>& submaps() const { return submaps_; }

  std::optional<Checkpoint> checkpoint;
  int checkpoints = 0;
  bool is_full = false;

 private:
  std::vector<std::shared_ptr<const Submap>> submaps_;
  std::map<uint64_t, TrajectoryEntry> trajectory_;
};

// A server's worker and the robot that sends to it; the robot keeps what is not durable.
class Session {
 public:
  Session(Store* store, SessionWorker::Options options) : store_(store), options_(options) {
    Start();
  }

  // Killed, and started anew; the robot sends again what it kept.
  void Restart() {
    worker_ = nullptr;
    Start();
    const WorkerStatus status = worker_->Status();
    ASSERT_GE(status.durable_sequence, robot_durable_) << "the robot has let go of these";
    for (uint64_t sequence = status.durable_sequence + 1; sequence <= sent_.size(); ++sequence) {
      const ScanAck ack = Submit(sequence);
      EXPECT_EQ(ack.outcome == ScanOutcome::kDuplicate, sequence <= status.last_sequence);
    }
  }

  ScanAck Send(PointPayload payload, int64_t end_stamp_ns) {
    sent_.push_back({sent_.size() + 1, end_stamp_ns, std::move(payload)});
    return Submit(sent_.size());
  }

  // From now on the robot has all its scans again, as an archive of them would.
  void KeepAll() { robot_durable_ = 0; }
  SessionWorker& worker() { return *worker_; }
  absl::Status TrySubmit(uint64_t sequence) { return worker_->Submit(sent_[sequence - 1]); }

 private:
  void Start() {
    SessionRecord record;
    record.id = SessionId("alice-1");
    record.robot = RobotId("alice");
    WorkerHooks hooks;
    hooks.persist = [this](const Stretch& stretch) { return store_->Persist(stretch); };
    hooks.T_map_odom = [] { return std::nullopt; };
    hooks.scan_done = [] {};
    worker_ = SessionWorker::Create(record, floam::FindSensorModel("vlp16").value(), options_,
                                    hooks, &executor_, store_->Resume());
    worker_->SetAckSink([this](const ScanAck& ack) { last_ack_ = ack; });
  }

  ScanAck Submit(uint64_t sequence) {
    last_ack_ = ScanAck();
    const absl::Status status = worker_->Submit(sent_[sequence - 1]);
    EXPECT_TRUE(status.ok()) << status;
    executor_.WaitUntilIdle();
    EXPECT_EQ(last_ack_.sequence, sequence);
    EXPECT_GE(last_ack_.durable_sequence, robot_durable_);
    robot_durable_ = last_ack_.durable_sequence;
    return last_ack_;
  }

  Store* const store_;
  const SessionWorker::Options options_;
  Executor executor_{1};
  std::shared_ptr<SessionWorker> worker_;
  std::vector<ScanUpload> sent_;
  uint64_t robot_durable_ = 0;  // As the robot knows.
  ScanAck last_ack_;
};

SessionWorker::Options SmallSubmaps() {
  SessionWorker::Options options;
  options.submap.cut_scans = 20;
  options.checkpoint_scans = 7;  // With an unfinished submap, mostly.
  return options;
}

struct Turn {
  PointPayload payload;
  int64_t end_stamp_ns = 0;
};

Turn MakeTurn(int index) {
  const Scan scan = MakeScan(floam::testing::FurnishedRoom(), floam::testing::Loop(1.2),
                             floam::testing::Sensor(), index);
  return {codec::MakePayload(scan), scan.end_stamp_ns};
}

PointPayload Blank() { return codec::MakePayload(std::vector<ScanPoint>(64), true, true); }

// A loop with what happens: blank scans, scans that never came, one out of order, a clock that is
// set back.
std::vector<Turn> TroubledDrive() {
  std::vector<Turn> turns;
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
  const std::vector<Turn> turns = TroubledDrive();
  Store undisturbed;
  Session calm(&undisturbed, SmallSubmaps());
  for (const Turn& turn : turns) calm.Send(turn.payload, turn.end_stamp_ns);
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
  std::optional<Checkpoint> older;
  for (int k = 0; k < 70; ++k) {
    const Turn turn = MakeTurn(k);
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
  EXPECT_EQ(ack.status, "ok");
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
      EXPECT_EQ(ack.status, "ok") << k;
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
  const Turn next = MakeTurn(k);
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
