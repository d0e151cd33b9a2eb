// Sessions whose scans come faster than the server deals with them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/codec/payload_builder.h"
#include "server/ingest/limits.h"
#include "server/ingest/pace.h"
#include "server/ingest/queue_room.h"
#include "server/ingest/session_worker.h"
#include "server/ingest/thin_scan.h"
#include "tests/floam/room.h"

namespace isthmus::ingest {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A worker whose only thread is held until it is let go.
class HeldWorker {
 public:
  explicit HeldWorker(WhenBehind when_behind, SessionWorker::Options options = {},
                      const std::string& robot = "alice") {
    SessionRecord record;
    record.id = SessionId(robot + "-1");
    record.robot = RobotId(robot);
    record.sensor = "vlp16";
    record.when_behind = when_behind;
    WorkerHooks hooks;
    hooks.persist = [](const FinishedSubmap&) { return absl::OkStatus(); };
    hooks.T_map_odom = [](uint32_t) { return std::nullopt; };
    hooks.scan_done = [this] { ++done; };
    worker = SessionWorker::Create(record, floam::FindSensorModel("vlp16").value(), options, hooks,
                                   &executor_, {});
    worker->SetAckSink([this](const ScanAck& ack) { acks.push_back(ack); });
    Hold();
  }
  ~HeldWorker() { LetGo(); }

  void Hold() {
    gate_ = std::promise<void>();
    executor_.Post([gate = gate_.get_future().share()] { gate.wait(); });
    held_ = true;
  }
  void LetGo() {
    if (held_) gate_.set_value();
    held_ = false;
    EXPECT_TRUE(executor_.WaitUntilIdle().ok());
  }
  absl::Status Send(int index) { return worker->Submit(Upload(index)); }
  // True if it was taken; else it is handed back as it was.
  bool Offer(int index) {
    ScanUpload scan = Upload(index);
    const auto taken = worker->Admit(&scan, false);
    EXPECT_TRUE(taken.ok()) << taken.status();
    if (taken.value_or(false)) return true;
    EXPECT_EQ(scan.payload.data, Upload(index).payload.data);
    return false;
  }
  std::vector<ScanOutcome> Outcomes() const {
    std::vector<ScanOutcome> outcomes;
    for (const ScanAck& ack : acks) outcomes.push_back(ack.outcome);
    return outcomes;
  }

  std::shared_ptr<SessionWorker> worker;
  std::vector<ScanAck> acks;
  int done = 0;

 private:
  ScanUpload Upload(int index) const {
    const Scan scan = MakeScan(room_, floam::testing::Loop(1.0), floam::testing::Sensor(), index);
    return {static_cast<uint64_t>(index) + 1, scan.end_stamp_ns, codec::MakePayload(scan)};
  }

  const floam::testing::Room room_ = floam::testing::FurnishedRoom();
  std::promise<void> gate_;
  bool held_ = false;
  Executor executor_{1};
};

constexpr ScanOutcome kUsed = ScanOutcome::kProcessed, kSkipped = ScanOutcome::kSkipped;

TEST(Behind, TheNewestAreKeptAndAllAreAcknowledgedInOrder) {
  HeldWorker held(WhenBehind::kKeepNewest);
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(held.Send(i).ok());
  held.LetGo();
  EXPECT_THAT(held.Outcomes(), ElementsAre(kSkipped, kSkipped, kSkipped, kSkipped, kUsed, kUsed));
  for (size_t i = 0; i < held.acks.size(); ++i) EXPECT_EQ(held.acks[i].sequence, i + 1);
  EXPECT_THAT(held.acks.front().reason, HasSubstr("keeps the newest"));
  EXPECT_FALSE(held.acks.front().T_odom_sensor.has_value());
  EXPECT_EQ(held.acks.back().scans.skipped, 4u);
  EXPECT_EQ(held.acks.back().scans.ok, 2u);
  EXPECT_EQ(held.worker->Status().scans.skipped, 4u);
  EXPECT_EQ(held.done, 6);
}

TEST(Behind, WhatIsSkippedIsUsedUpAndDurableOnceFinished) {
  HeldWorker held(WhenBehind::kKeepNewest);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(held.Send(i).ok());
  held.LetGo();
  ASSERT_TRUE(held.Send(1).ok());  // Again.
  held.LetGo();
  EXPECT_EQ(held.acks.back().outcome, ScanOutcome::kDuplicate);
  ASSERT_TRUE(held.worker->Finish().ok());
  EXPECT_EQ(held.acks.back().durable_sequence, 5u);
}

TEST(Behind, WhoWaitsLosesNothing) {
  HeldWorker held(WhenBehind::kWait);
  std::thread robot([&] {
    for (int i = 0; i < 20; ++i) EXPECT_TRUE(held.Send(i).ok());
  });
  held.LetGo();
  robot.join();
  held.LetGo();
  EXPECT_EQ(held.acks.size(), 20u);
  EXPECT_EQ(held.worker->Status().scans.ok, 20u);
}

TEST(Behind, BytesAreBoundedAndWhatIsLargerWaitsAlone) {
  SessionWorker::Options options;
  options.queue_bytes = 1;
  HeldWorker held(WhenBehind::kWait, options);
  ASSERT_TRUE(held.Send(0).ok());  // Nothing waits before it.
  EXPECT_FALSE(held.Offer(1));
  std::thread robot([&] { EXPECT_TRUE(held.Send(1).ok()); });
  // It can only be taken once the first is at hand.
  held.LetGo();
  robot.join();
  held.LetGo();
  EXPECT_THAT(held.Outcomes(), ElementsAre(kUsed, kUsed));
}

TEST(Behind, WhoKeepsTheNewestNeverWaitsForBytes) {
  SessionWorker::Options options;
  options.queue_bytes = 1;
  HeldWorker held(WhenBehind::kKeepNewest, options);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(held.Send(i).ok());
  held.LetGo();
  EXPECT_THAT(held.Outcomes(), ElementsAre(kSkipped, kSkipped, kUsed));
}

TEST(Behind, RoomThatOthersTookIsGivenBack) {
  SessionWorker::Options options;
  options.room = std::make_shared<QueueRoom>(1);
  HeldWorker greedy(WhenBehind::kWait, options), modest(WhenBehind::kKeepNewest, options, "bob");
  // A small scan always has room where none of its session waits ...
  ASSERT_TRUE(greedy.Send(0).ok());
  ASSERT_TRUE(modest.Send(0).ok());
  // ... a second one waits, or what waits gives way.
  EXPECT_FALSE(greedy.Offer(1));
  std::thread robot([&] { EXPECT_TRUE(greedy.Send(1).ok()); });
  ASSERT_TRUE(modest.Send(1).ok());
  greedy.LetGo();
  robot.join();
  greedy.LetGo();
  modest.LetGo();
  EXPECT_THAT(greedy.Outcomes(), ElementsAre(kUsed, kUsed));
  EXPECT_THAT(modest.Outcomes(), ElementsAre(kSkipped, kUsed));
  EXPECT_EQ(options.room->used(), 0u);
}

TEST(Behind, WhoWaitsForRoomOfOthersIsToldThatTheSessionEnds) {
  SessionWorker::Options options;
  options.room = std::make_shared<QueueRoom>(1);
  HeldWorker held(WhenBehind::kWait, options);
  ASSERT_TRUE(held.Send(0).ok());
  std::thread robot([&] { EXPECT_EQ(held.Send(1).code(), absl::StatusCode::kUnavailable); });
  held.worker->StopTaking();
  robot.join();
  held.LetGo();
  EXPECT_TRUE(held.acks.empty());  // Let go of: the robot has it still.
  EXPECT_EQ(held.done, 1);
  EXPECT_TRUE(held.worker->Finish().ok());
  EXPECT_EQ(held.worker->Status().last_sequence, 0u);
  EXPECT_EQ(options.room->used(), 0u);
}

TEST(Behind, ScansOfTooManyPointsAreRejectedInOrderAndTakeNoMemory) {
  SessionWorker::Options options;
  options.max_points = 100;
  options.queue = 1;
  options.room = std::make_shared<QueueRoom>(size_t{1} << 30);
  HeldWorker held(WhenBehind::kWait, options);
  ASSERT_TRUE(held.Send(0).ok());
  EXPECT_LT(options.room->used(), 10'000u);
  EXPECT_FALSE(held.Offer(1));
  held.LetGo();
  EXPECT_TRUE(held.Offer(1));
  held.LetGo();
  ASSERT_THAT(held.Outcomes(), ElementsAre(ScanOutcome::kRejected, ScanOutcome::kRejected));
  for (const ScanAck& ack : held.acks) EXPECT_THAT(ack.reason, HasSubstr("ingest.max_scan_points"));
}

TEST(Behind, FasterThanTheLimitOnTheRateARobotWaitsOrSkips) {
  int64_t now_ns = 0;
  SessionWorker::Options options;
  options.max_rate_hz = 1;
  options.now_ns = [&now_ns] { return now_ns; };
  HeldWorker patient(WhenBehind::kWait, options), newest(WhenBehind::kKeepNewest, options, "bob");
  // Two seconds of scans and one more may come at once.
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(patient.Offer(i)) << i;
    ASSERT_TRUE(newest.Send(i).ok());
    newest.LetGo();
    newest.Hold();
  }
  EXPECT_FALSE(patient.Offer(3));
  EXPECT_TRUE(newest.Offer(3)) << "it never waits";
  now_ns += 1'000'000'000;
  EXPECT_TRUE(patient.Offer(3));
  ASSERT_TRUE(newest.Send(4).ok());
  newest.LetGo();
  EXPECT_THAT(newest.Outcomes(), ElementsAre(kUsed, kUsed, kUsed, kSkipped, kUsed));
}

TEST(Pace, ARobotIsLiveWhateverItsNetworkDoes) {
  Pace pace;
  constexpr int64_t kSecond = 1'000'000'000;
  int64_t now = 0;
  for (int i = 0; i < 600; ++i) {
    // Bursts of a second.
    if (i % 10 == 0) now += kSecond;
    pace.NoteScan(i * kSecond / 10, now);
    EXPECT_FALSE(pace.IsBackfill()) << i;
  }
}

TEST(Pace, ARecordingIsBackfillUntilItsRobotHasCaughtUp) {
  Pace pace;
  constexpr int64_t kSecond = 1'000'000'000;
  for (int i = 0; i < 100; ++i) pace.NoteScan(i * kSecond / 10, i * kSecond / 100);
  EXPECT_TRUE(pace.IsBackfill());
  int64_t now = kSecond, stamp = 10 * kSecond;
  // From here on as they are measured, but for a pause in which it catches up.
  for (int i = 0; i < 10; ++i) pace.NoteScan(stamp += kSecond / 10, now += kSecond / 10);
  EXPECT_TRUE(pace.IsBackfill());
  pace.NoteScan(stamp += kSecond / 10, now += 5 * kSecond);
  EXPECT_FALSE(pace.IsBackfill());
}

TEST(Pace, StampsThatJumpSayNothing) {
  Pace pace;
  int64_t now = 0;
  for (const int64_t stamp : {int64_t{5}, INT64_MAX, INT64_MIN, int64_t{0}, INT64_MAX / 2}) {
    pace.NoteScan(stamp, ++now);
    EXPECT_FALSE(pace.IsBackfill());
  }
}

TEST(ThinScan, KeepsTheOrderAndAllRingsAlike) {
  Scan scan;
  constexpr int kRings = 16, kColumns = 20'000;
  for (int i = 0; i < kRings * kColumns; ++i) {
    scan.points.push_back({.x = static_cast<float>(i), .ring = static_cast<uint16_t>(i % kRings)});
  }
  Scan same = scan;
  ThinScan(scan.points.size(), &same);
  EXPECT_EQ(same.points.size(), scan.points.size());
  ThinScan(scan.points.size() / 4, &scan);
  EXPECT_NEAR(static_cast<double>(scan.points.size()), 0.25 * kRings * kColumns, 0.1 * kColumns);
  std::vector<int> of_ring(kRings);
  for (size_t i = 0; i < scan.points.size(); ++i) {
    ++of_ring[scan.points[i].ring];
    if (i > 0) {
      EXPECT_GT(scan.points[i].x, scan.points[i - 1].x);
    }
  }
  for (const int count : of_ring) EXPECT_NEAR(count, 0.25 * kColumns, 0.025 * kColumns);
}

}  // namespace
}  // namespace isthmus::ingest
