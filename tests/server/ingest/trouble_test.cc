// Scans from robots in trouble: every scan is answered, with a reason, and the session goes on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <new>
#include <utility>

#include "core/codec/payload_builder.h"
#include "tests/server/ingest/worker_fixture.h"

namespace isthmus::ingest {
namespace {

using ::testing::HasSubstr;
using testing::Rig;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr int64_t kHour_ns = 3'600'000'000'000;

void ExpectTracked(const Rig& rig, const ScanAck& ack, int index) {
  EXPECT_EQ(ack.outcome, ScanOutcome::kProcessed) << index << ": " << ack.reason;
  EXPECT_EQ(ack.tracking, Tracking::kOk) << index;
  EXPECT_LT(rig.Error(ack, index), 0.05) << index;
  ASSERT_TRUE(ack.covariance.has_value());
  EXPECT_TRUE(ack.covariance->allFinite());
}

void DriveOn(Rig* rig, int from, int to, int64_t shift_ns = 0) {
  for (int k = from; k < to; ++k) ExpectTracked(*rig, rig->Send(rig->Turn(k), shift_ns), k);
}

// As DriveOn after a gap in time or place: the robot may be lost, and say so, for a few scans.
void DriveAfterGap(Rig* rig, int from, int to, int64_t shift_ns = 0) {
  constexpr int kLost = 5;
  int k = from;
  for (ScanAck ack; ack.tracking != Tracking::kOk && k < from + kLost; ++k) {
    ack = rig->Send(rig->Turn(k), shift_ns);
    EXPECT_EQ(ack.outcome, ScanOutcome::kProcessed) << k << ": " << ack.reason;
    if (ack.tracking == Tracking::kOk) ExpectTracked(*rig, ack, k);
  }
  DriveOn(rig, k, to, shift_ns);
}

void ExpectRejected(const ScanAck& ack, Tracking tracking, const std::string& reason) {
  EXPECT_EQ(ack.outcome, ScanOutcome::kRejected);
  EXPECT_EQ(ack.tracking, tracking);
  EXPECT_THAT(ack.reason, HasSubstr(reason));
  EXPECT_FALSE(ack.T_odom_sensor.has_value());
}

// As a driver sends a turn in which nothing came back.
PointPayload AllPointsAt(float value) {
  std::vector<ScanPoint> points(16 * 1200);
  for (ScanPoint& p : points) p.x = p.y = p.z = value;
  return codec::MakePayload(points, true, true);
}

TEST(Trouble, DuplicatesAreAcknowledgedAndIgnored) {
  Rig rig;
  DriveOn(&rig, 0, 5);
  const ScanAck ack = rig.SendAgain(5);
  EXPECT_EQ(ack.outcome, ScanOutcome::kDuplicate);
  EXPECT_EQ(rig.SendAgain(2).outcome, ScanOutcome::kDuplicate);
  DriveOn(&rig, 5, 10);
  EXPECT_EQ(rig.worker().Status().processed, 10u);
}

TEST(Trouble, ScansThatNeverCameAreBridged) {
  Rig rig;
  DriveOn(&rig, 0, 20);
  DriveOn(&rig, 21, 24);
  DriveAfterGap(&rig, 26, 30);
  DriveAfterGap(&rig, 50, 60);  // Two seconds, at 1 m/s and in a turn.
}

TEST(Trouble, ScansOutOfOrderAndEqualStampsAreRejected) {
  Rig rig;
  DriveOn(&rig, 0, 10);
  ExpectRejected(rig.Send(rig.Turn(8)), Tracking::kUnknown, "out of order");
  ExpectRejected(rig.Send(rig.Turn(8)), Tracking::kUnknown, "sent twice");
  EXPECT_EQ(rig.worker().Status().tracking, Tracking::kOk);
  EXPECT_EQ(rig.worker().Status().rejected, 2u);
  DriveOn(&rig, 10, 15);
  ExpectRejected(rig.Send(rig.Turn(14)), Tracking::kUnknown, "sent twice");
  DriveOn(&rig, 15, 20);
}

// One scan is lost to a clock that was set back, by however much.
void DriveAfterStepBack(Rig* rig, int from, int to, int64_t shift_ns) {
  ExpectRejected(rig->Send(rig->Turn(from), shift_ns), Tracking::kUnknown, "set back");
  DriveOn(rig, from + 1, to, shift_ns);
}

TEST(Trouble, ClocksMayBeSetBackAndForth) {
  Rig rig;
  DriveOn(&rig, 0, 20);
  DriveAfterStepBack(&rig, 20, 30, -kHour_ns);
  DriveAfterStepBack(&rig, 30, 35, -kHour_ns - 200'000'000);
  DriveAfterStepBack(&rig, 35, 40, -kHour_ns - 2'000'000'000);
  DriveAfterGap(&rig, 40, 50);
  DriveAfterGap(&rig, 50, 60, 5 * kHour_ns);
  EXPECT_EQ(rig.Send(rig.Turn(60), 500 * kHour_ns).outcome,
            ScanOutcome::kProcessed);  // One stamp is nonsense.
  DriveAfterStepBack(&rig, 61, 70, 5 * kHour_ns);
  // Stamps are the robot's, and in order within every submap.
  ASSERT_TRUE(rig.worker().Finish().ok());
  ASSERT_GE(rig.stored().size(), 6u);
  for (const FinishedSubmap& finished : rig.stored()) {
    int64_t last_ns = std::numeric_limits<int64_t>::min();
    for (const TrajectoryEntry& entry : finished.trajectory) {
      EXPECT_GT(entry.stamp_ns, last_ns);
      EXPECT_EQ(entry.submap_index, finished.submap->id.index);
      last_ns = entry.stamp_ns;
    }
    EXPECT_EQ(finished.submap->first_stamp_ns, finished.trajectory.front().stamp_ns);
    EXPECT_EQ(finished.submap->last_stamp_ns, finished.trajectory.back().stamp_ns);
  }
}

TEST(Trouble, SmallStepsBackCostOneScan) {
  Rig rig;
  DriveOn(&rig, 0, 20);
  ExpectRejected(rig.Send(rig.Turn(20), -500'000'000), Tracking::kUnknown, "out of order");
  DriveAfterGap(&rig, 21, 31, -500'000'000);
}

TEST(Trouble, BlankScansSayThatTheRobotIsLostUntilItSeesAgain) {
  for (const float value : {0.F, kNaN}) {
    Rig rig;
    DriveOn(&rig, 0, 30);
    for (int k = 30; k < 50; ++k) {
      const ScanAck ack = rig.Send(AllPointsAt(value), rig.Turn(k).end_stamp_ns);
      ExpectRejected(ack, Tracking::kLost, "no returns");
      EXPECT_EQ(rig.worker().Status().tracking, Tracking::kLost);
      // The submap ends once the odometry cannot bridge it.
      EXPECT_EQ(rig.stored().size(), k < 32 ? 0u : 1u);
    }
    EXPECT_EQ(rig.stored().front().submap->last_sequence, 30u);
    DriveAfterGap(&rig, 50, 60);
    EXPECT_EQ(rig.worker().Status().tracking, Tracking::kOk);
  }
}

TEST(Trouble, ScansWithoutPointsAreRejected) {
  Rig rig;
  DriveOn(&rig, 0, 5);
  PointPayload empty = codec::MakePayload(rig.Turn(5));
  empty.width = empty.height = 0;
  empty.data.clear();
  ExpectRejected(rig.Send(empty, rig.Turn(5).end_stamp_ns), Tracking::kLost, "no points");
  DriveOn(&rig, 6, 10);
}

TEST(Trouble, HalfBlankScansAreTracked) {
  // A hand hides the half of the turn around its start and end, or that around its middle.
  for (const bool front : {true, false}) {
    for (const bool fields : {true, false}) {
      Rig rig;
      DriveOn(&rig, 0, 30);
      for (int k = 30; k < 50; ++k) {
        Scan scan = rig.Turn(k);
        std::erase_if(scan.points, [&](const ScanPoint& p) { return (p.x > 0) == front; });
        scan.has_ring = scan.has_time = fields;
        ExpectTracked(rig, rig.Send(scan), k);
      }
      DriveOn(&rig, 50, 55);
    }
  }
}

TEST(Trouble, PointsThatAreNoNumbersAreLeftOut) {
  Rig rig;
  DriveOn(&rig, 0, 10);
  for (int k = 10; k < 20; ++k) {
    Scan scan = rig.Turn(k);
    for (size_t i = 0; i < scan.points.size(); i += 7) {
      scan.points[i].x = i % 2 == 0 ? kNaN : std::numeric_limits<float>::infinity();
    }
    ExpectTracked(rig, rig.Send(scan), k);
  }
}

TEST(Trouble, DamagedPayloadsAreRejected) {
  Rig rig;
  DriveOn(&rig, 0, 5);
  PointPayload damaged = codec::MakePayload(rig.Turn(5));
  damaged.data.resize(damaged.data.size() / 2);
  ExpectRejected(rig.Send(damaged, rig.Turn(5).end_stamp_ns), Tracking::kLost, "do not make");
  DriveOn(&rig, 6, 10);
}

// A scan that cannot be matched is no part of any map or trajectory.
TEST(Trouble, LostScansEndTheSubmapAndAreNotStored) {
  Rig rig;
  DriveOn(&rig, 0, 30);
  floam::testing::Room elsewhere;
  elsewhere.walls = {{-1.9, -0.8, -0.5}, {0.7, 2.4, 0.6}};
  const auto still = [](double) { return Pose(); };
  for (int k = 30; k < 34; ++k) {
    const ScanAck ack = rig.Send(MakeScan(elsewhere, still, floam::testing::Sensor(), k));
    EXPECT_EQ(ack.outcome, ScanOutcome::kProcessed);
    EXPECT_EQ(ack.tracking, Tracking::kLost);
    EXPECT_EQ(rig.stored().size(), 1u);
  }
  EXPECT_EQ(rig.worker().Status().tracking, Tracking::kLost);
  for (int k = 34; k < 50; ++k) rig.Send(rig.Turn(k));
  ASSERT_TRUE(rig.worker().Finish().ok());
  for (const FinishedSubmap& finished : rig.stored()) {
    for (const TrajectoryEntry& entry : finished.trajectory) {
      EXPECT_GE(entry.sequence, finished.submap->first_sequence);
      EXPECT_LE(entry.sequence, finished.submap->last_sequence);
      EXPECT_FALSE(entry.sequence > 30 && entry.sequence <= 34) << entry.sequence;
    }
  }
}

// The work at hand may be half done, so nothing of it is used any more.
TEST(Trouble, WhatIsThrownCostsThatScanAndTheSegment) {
  Rig rig;
  DriveOn(&rig, 0, 20);
  bool throws = false;
  std::vector<std::string> told;
  rig.on_told = [&](const std::string& what) {
    if (std::exchange(throws, false)) throw std::bad_alloc();
    told.push_back(what);
  };
  for (int k = 20; k < 23; ++k) {
    throws = k == 22;  // Told that it is lost, in the middle of rejecting the third.
    ExpectRejected(rig.Send(AllPointsAt(0), rig.Turn(k).end_stamp_ns), Tracking::kLost,
                   k < 22 ? "no returns" : "not enough memory");
  }
  EXPECT_TRUE(told.empty());
  const ScanAck ack = rig.Send(rig.Turn(23));
  EXPECT_EQ(ack.outcome, ScanOutcome::kProcessed) << ack.reason;
  EXPECT_EQ(ack.segment, 2u);
  ASSERT_EQ(told.size(), 1u);
  EXPECT_THAT(told[0], HasSubstr("goes on in segment 2"));
  EXPECT_EQ(rig.worker().Status().rejected, 3u);
  EXPECT_EQ(rig.worker().Status().scans.rejected, 3u);
  for (int k = 24; k < 30; ++k) {
    EXPECT_EQ(rig.Send(rig.Turn(k)).tracking, Tracking::kOk) << k;
  }
  ASSERT_TRUE(rig.worker().Finish().ok());
  // The first segment's was cut whole before anything was thrown.
  ASSERT_EQ(rig.stored().size(), 2u);
  EXPECT_EQ(rig.stored()[0].submap->id.session, SessionId("alice-1"));
  EXPECT_EQ(rig.stored()[0].submap->last_sequence, 20u);
  EXPECT_EQ(rig.stored()[1].segment, 2u);
}

}  // namespace
}  // namespace isthmus::ingest
