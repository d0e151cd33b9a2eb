#include "core/scan_clock.h"

#include <gtest/gtest.h>

#include <limits>

namespace isthmus {
namespace {

constexpr int64_t kMs = 1'000'000;
constexpr int64_t kStart = 1'700'000'000'000 * kMs;
constexpr int64_t kHour = 3'600'000 * kMs;

// Reads and uses a scan; its time must be later than that of the one before it.
class Robot {
 public:
  // Nanoseconds since the scan before it.
  int64_t Send(int64_t stamp_ns) {
    const auto reading = clock_.Read(stamp_ns);
    EXPECT_TRUE(reading.ok()) << reading.status();
    const int64_t since = reading->time_ns - time_ns_;
    stepped_ = reading->stepped;
    time_ns_ = reading->time_ns;
    clock_.Advance(stamp_ns, reading->time_ns);
    return since;
  }
  bool Refused(int64_t stamp_ns) { return !clock_.Read(stamp_ns).ok(); }
  bool stepped() const { return stepped_; }
  int64_t time_ns() const { return time_ns_; }

 private:
  ScanClock clock_;
  int64_t time_ns_ = 0;
  bool stepped_ = false;
};

TEST(ScanClock, FollowsStampsThatGoForward) {
  Robot robot;
  robot.Send(kStart);
  EXPECT_EQ(robot.time_ns(), kStart);
  EXPECT_EQ(robot.Send(kStart + 100 * kMs), 100 * kMs);
  EXPECT_EQ(robot.Send(kStart + 151 * kMs), 51 * kMs);
  EXPECT_EQ(robot.Send(kStart + 5000 * kMs), 4849 * kMs);
  EXPECT_FALSE(robot.stepped());
}

TEST(ScanClock, RefusesScansOutOfOrderAndGoesOn) {
  Robot robot;
  robot.Send(kStart);
  EXPECT_TRUE(robot.Refused(kStart));
  EXPECT_TRUE(robot.Refused(kStart - 100 * kMs));
  EXPECT_TRUE(robot.Refused(kStart - 1000 * kMs));
  EXPECT_EQ(robot.Send(kStart + 100 * kMs), 100 * kMs);
}

TEST(ScanClock, AStepBackCostsOneScan) {
  // By some scans, by hours, and by all the years since 1970.
  for (const int64_t back : {120 * kMs, 300 * kMs, 1100 * kMs, kHour, kStart}) {
    Robot robot;
    robot.Send(kStart);
    robot.Send(kStart + 50 * kMs);
    EXPECT_TRUE(robot.Refused(kStart + 100 * kMs - back));
    EXPECT_EQ(robot.Send(kStart + 150 * kMs - back), 100 * kMs);
    EXPECT_TRUE(robot.stepped());
    EXPECT_EQ(robot.Send(kStart + 200 * kMs - back), 50 * kMs);
    EXPECT_FALSE(robot.stepped());
  }
}

TEST(ScanClock, OneWildStampDoesNotCostAllThatFollow) {
  Robot robot;
  robot.Send(kStart);
  robot.Send(kStart + kHour);
  EXPECT_TRUE(robot.Refused(kStart + 100 * kMs));
  robot.Send(kStart + 200 * kMs);
  EXPECT_TRUE(robot.stepped());
  EXPECT_EQ(robot.Send(kStart + 300 * kMs), 100 * kMs);
}

TEST(ScanClock, WhatIsSentTwiceOrSwappedIsRefusedAlone) {
  Robot robot;
  robot.Send(kStart + 200 * kMs);
  EXPECT_TRUE(robot.Refused(kStart + 100 * kMs));
  EXPECT_TRUE(robot.Refused(kStart + 100 * kMs));
  EXPECT_EQ(robot.Send(kStart + 300 * kMs), 100 * kMs);
  EXPECT_TRUE(robot.Refused(kStart + 300 * kMs));
  EXPECT_EQ(robot.Send(kStart + 400 * kMs), 100 * kMs);
  EXPECT_FALSE(robot.stepped());
}

TEST(ScanClock, BoundsAStepForward) {
  Robot robot;
  robot.Send(kStart);
  EXPECT_EQ(robot.Send(kStart + 1000 * kHour), 10'000 * kMs);
  EXPECT_TRUE(robot.stepped());
  EXPECT_EQ(robot.Send(kStart + 1000 * kHour + 100 * kMs), 100 * kMs);
}

TEST(ScanClock, RefusesStampsThatAreNoTimes) {
  Robot robot;
  EXPECT_TRUE(robot.Refused(std::numeric_limits<int64_t>::max()));
  EXPECT_TRUE(robot.Refused(std::numeric_limits<int64_t>::min()));
  robot.Send(0);
  EXPECT_TRUE(robot.Refused(std::numeric_limits<int64_t>::max()));
  EXPECT_TRUE(robot.Refused(std::numeric_limits<int64_t>::min()));
}

}  // namespace
}  // namespace isthmus
