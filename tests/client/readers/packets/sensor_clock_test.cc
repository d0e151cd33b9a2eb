#include "client/readers/packets/sensor_clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

namespace isthmus::readers {
namespace {

using ::testing::HasSubstr;

constexpr int64_t kSecond = 1'000'000'000;
constexpr int64_t kHour = 3600 * kSecond;

TEST(SensorClock, FollowsAFreeClockThatDrifts) {
  for (const double drift : {-50e-6, 50e-6}) {
    SensorClock clock(0);
    int64_t worst = 0;
    for (int i = 0; i < 36000; ++i) {  // An hour.
      const int64_t arrival = 1'700'000'000 * kSecond + i * kSecond / 10;
      const int64_t sensor = static_cast<int64_t>(i * 1e8 * (1 + drift));
      const int64_t time = clock.Read(sensor, arrival + (i % 7) * 1'000'000);
      worst = std::max(worst, std::abs(time + clock.offset_ns() - arrival));
    }
    EXPECT_LT(worst, 2'000'000) << drift;
  }
}

TEST(SensorClock, GoesOnWhereTheSensorStartsAgain) {
  SensorClock clock(0);
  clock.Read(500 * kSecond, 1'700'000'000 * kSecond);
  const int64_t time = clock.Read(0, 1'700'000'060 * kSecond);
  EXPECT_EQ(time + clock.offset_ns(), 1'700'000'060 * kSecond);
}

TEST(SensorClock, LeavesASynchronisedClockThatGoesAway) {
  SensorClock clock(kHour);
  const int64_t hour = 472'222 * kHour;
  EXPECT_EQ(clock.Read(5 * kSecond, hour + 5 * kSecond + 1000), hour + 5 * kSecond);
  EXPECT_EQ(clock.offset_ns(), 0);
  const int64_t time = clock.Read(60 * kSecond, hour + 10 * kSecond);
  EXPECT_EQ(time + clock.offset_ns(), hour + 10 * kSecond);
  EXPECT_THAT(clock.Description(), HasSubstr("went away"));
}

TEST(SensorClock, FreeClockHalfAnHourOffDoesNotJump) {
  SensorClock clock(kHour);
  const int64_t start = 472'222 * kHour;
  int64_t last = 0;
  for (int i = 0; i < 100; ++i) {
    const int64_t jitter = (i % 2) * 3'000'000;  // Around half of the period.
    const int64_t time =
        clock.Read(i * kSecond, start + kHour / 2 + i * kSecond + jitter - 1'500'000);
    if (i > 0) {
      EXPECT_EQ(time - last, kSecond);
    }
    last = time;
  }
}

TEST(SensorClock, AnyNumbersAreSafe) {
  for (const int64_t period : {int64_t{0}, kHour}) {
    SensorClock clock(period, period > 0 ? std::optional(INT64_MIN + 1) : std::nullopt);
    for (const int64_t a : {INT64_MIN, int64_t{-1}, int64_t{0}, INT64_MAX}) {
      for (const int64_t b : {INT64_MAX, int64_t{0}, INT64_MIN}) clock.Read(a, b);
    }
    EXPECT_FALSE(clock.Description().empty());
  }
}

}  // namespace
}  // namespace isthmus::readers
