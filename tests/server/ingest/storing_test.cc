// A session whose submaps are stored beside the scans that follow: answers to robots while the disk
// is busy, and after.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <vector>

#include "core/codec/payload_builder.h"
#include "core/concurrency/mutex.h"
#include "server/ingest/session_worker.h"
#include "tests/floam/room.h"
#include "tests/server/ingest/worker_fixture.h"

namespace isthmus::ingest {
namespace {

// A session with submaps of 20 scans and checkpoints after 7, whose disk is busy until it is free.
class BusyDisk {
 public:
  BusyDisk() {
    SessionRecord record;
    record.id = SessionId("alice-1");
    record.robot = RobotId("alice");
    WorkerHooks hooks;
    hooks.persist = [this](const FinishedSubmap& finished) { return Persist(finished); };
    hooks.T_map_odom = [](uint32_t) { return std::nullopt; };
    hooks.scan_done = [this] {
      MutexLock lock(&mutex_);
      ++done_;
      changed_.SignalAll();
    };
    SessionWorker::Options options = testing::SmallSubmaps();
    options.storing = &storing_;
    worker = SessionWorker::Create(record, floam::FindSensorModel("vlp16").value(), options, hooks,
                                   &executor_, {});
    worker->SetAckSink([this](const ScanAck& ack) {
      MutexLock lock(&mutex_);
      acks_.push_back(ack);
      changed_.SignalAll();
    });
  }
  ~BusyDisk() { Free(); }

  void Free() {
    if (!is_free_) disk_.set_value();
    is_free_ = true;
  }
  void Send(int count) {
    for (int i = 0; i < count; ++i) {
      const Scan scan =
          MakeScan(room_, floam::testing::Loop(1.0), floam::testing::Sensor(), sent_++);
      const absl::Status status = worker->Submit(
          {static_cast<uint64_t>(sent_), scan.end_stamp_ns, codec::MakePayload(scan)});
      EXPECT_TRUE(status.ok()) << status;
    }
  }
  void WaitForAcks(size_t count) {
    MutexLock lock(&mutex_);
    while (acks_.size() < count) changed_.Wait(&mutex_);
  }
  void WaitForDone(int count) {
    MutexLock lock(&mutex_);
    while (done_ < count) changed_.Wait(&mutex_);
  }
  void WaitUntilIdle() {
    EXPECT_TRUE(executor_.WaitUntilIdle().ok());
    EXPECT_TRUE(storing_.WaitUntilIdle().ok());
  }
  std::vector<ScanAck> acks() const {
    MutexLock lock(&mutex_);
    return acks_;
  }
  int done() const {
    MutexLock lock(&mutex_);
    return done_;
  }
  // The number of acks when each was stored.
  std::vector<size_t> stored() const {
    MutexLock lock(&mutex_);
    return stored_;
  }

  std::shared_ptr<SessionWorker> worker;

 private:
  absl::Status Persist(const FinishedSubmap&) {
    busy_.wait();
    MutexLock lock(&mutex_);
    stored_.push_back(acks_.size());
    return absl::OkStatus();
  }

  const floam::testing::Room room_ = floam::testing::FurnishedRoom();
  std::promise<void> disk_;
  const std::shared_future<void> busy_ = disk_.get_future().share();
  bool is_free_ = false;
  int sent_ = 0;
  mutable Mutex mutex_;
  CondVar changed_;
  std::vector<ScanAck> acks_ ABSL_GUARDED_BY(mutex_);
  std::vector<size_t> stored_ ABSL_GUARDED_BY(mutex_);
  int done_ ABSL_GUARDED_BY(mutex_) = 0;
  Executor storing_{1};
  Executor executor_{1};
};

TEST(Storing, ARobotDoesNotWaitForTheDisk) {
  BusyDisk session;
  session.Send(13);  // After the seventh there is a checkpoint.
  session.WaitForAcks(13);
  session.WaitForDone(12);
  for (size_t i = 0; i < 13; ++i) {
    EXPECT_EQ(session.acks()[i].sequence, i + 1);
    EXPECT_EQ(session.acks()[i].outcome, ScanOutcome::kProcessed);
  }
  EXPECT_TRUE(session.stored().empty());
  EXPECT_EQ(session.done(), 12) << "the seventh is not done before it is stored";
  session.Free();
  session.WaitForDone(13);
  session.WaitUntilIdle();
  EXPECT_EQ(session.stored().size(), 1u);
  EXPECT_EQ(session.acks().back().sequence, 0u);
}

TEST(Storing, ASessionWaitsWhereTheDiskIsASubmapBehind) {
  BusyDisk session;
  session.Send(14);  // A second checkpoint, while the first is being stored.
  session.WaitForAcks(14);
  session.Send(3);
  session.Free();
  session.WaitUntilIdle();
  ASSERT_EQ(session.stored().size(), 2u);
  EXPECT_EQ(session.stored()[0], 14u);
  // But for the ack of no scan that says that the first is stored.
  EXPECT_LE(session.stored()[1], 15u);
  EXPECT_EQ(session.done(), 17);
}

TEST(Storing, WhatIsDurableIsToldOnceItIsAndNeverShrinks) {
  BusyDisk session;
  session.Send(22);
  session.Free();
  session.Send(30);
  session.WaitUntilIdle();
  uint64_t durable = 0;
  for (const ScanAck& ack : session.acks()) {
    EXPECT_GE(ack.durable_sequence, durable);
    durable = ack.durable_sequence;
  }
  EXPECT_GE(durable, 40u);
  EXPECT_EQ(session.done(), 52);
  ASSERT_TRUE(session.worker->Finish().ok());
  EXPECT_EQ(session.acks().back().durable_sequence, 52u);
}

TEST(Storing, ASessionThatIsDroppedWaitsForNothingButWhatIsBeingStored) {
  BusyDisk session;
  session.Send(10);
  session.WaitForAcks(10);
  session.Free();
  session.worker->Abandon();
  session.WaitUntilIdle();
  EXPECT_LE(session.stored().size(), 1u);
  EXPECT_EQ(session.done(), 10);
}

}  // namespace
}  // namespace isthmus::ingest
