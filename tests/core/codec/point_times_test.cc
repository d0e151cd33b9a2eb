#include "core/codec/point_times.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <random>
#include <utility>
#include <vector>

namespace isthmus::codec {
namespace {

using ::testing::HasSubstr;
using enum ScalarType;

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr int kTimedPoints = 1000;
constexpr double kTurn_s = 0.1;
constexpr int64_t kStamp_ns = 1'700'000'000'123'456'789;

// The part [from, to] of a turn, as seconds since the turn's start.
std::vector<double> Part(double from, double to) {
  std::vector<double> times;
  for (int i = 0; i < kTimedPoints; ++i) {
    const double fraction = static_cast<double>(i) / (kTimedPoints - 1);
    if (fraction >= from && fraction <= to) times.push_back(fraction * kTurn_s);
  }
  return times;
}

// As a driver writes them: (seconds + offset) / unit, which then starts again at `modulus`.
std::vector<double> Written(std::vector<double> times, double offset_s, double unit_s,
                            double modulus) {
  for (double& t : times) {
    t = (t + offset_s) / unit_s;
    if (modulus > 0) t = std::fmod(t, modulus);
  }
  return times;
}

struct Convention {
  const char* name;
  ScalarType type;
  double offset_s, unit_s, modulus;
  const char* said;
};

const Convention kConventions[] = {
    {"OusterNs", kUint32, 0, 1e-9, 0, "ns, from the start"},
    {"VelodyneS", kFloat32, 0, 1, 0, "s, from the start"},
    {"VelodyneToEnd", kFloat32, -kTurn_s, 1, 0, "s, up to the end"},
    {"Us", kFloat32, 0, 1e-6, 0, "us, from the start"},
    {"Ms", kFloat64, -kTurn_s, 1e-3, 0, "ms, up to the end"},
    {"HesaiUnixS", kFloat64, 1.7e9, 1, 0, "s, of a clock"},
    {"UnixUs", kFloat64, 1.7e9, 1e-6, 0, "us, of a clock"},
    {"UnixNs", kFloat64, 1.7e9, 1e-9, 0, "ns, of a clock"},
    {"Ns32Wraps", kUint32, 4294967296e-9 - 0.03, 1e-9, 4294967296.0, "ns, of a clock"},
    {"HourUsWraps", kUint32, 3600 - 0.08, 1e-6, 3.6e9, "us, of a clock"},
    {"HourSWraps", kFloat64, 3600 - 0.06, 1, 3600, "s, of a clock"},
    {"SecondNsWraps", kUint32, 1 - 0.05, 1e-9, 1e9, "ns, of a clock"},
};

class Conventions : public ::testing::TestWithParam<Convention> {};

INSTANTIATE_TEST_SUITE_P(All, Conventions, ::testing::ValuesIn(kConventions),
                         [](const auto& param) { return param.param.name; });

TEST_P(Conventions, AreReadRelativeToTheEnd) {
  const Convention& c = GetParam();
  const std::vector<double> truth = Part(0, 1);
  std::vector<double> times = Written(truth, c.offset_s, c.unit_s, c.modulus);
  TimeReader reader;
  ASSERT_TRUE(reader.Read(c.type, kStamp_ns, times));
  for (size_t i = 0; i < times.size(); ++i) {
    EXPECT_NEAR(times[i], truth[i] - kTurn_s, 1e-6) << i;
  }
  EXPECT_THAT(reader.Description(), HasSubstr(c.said));
}

// A hand over the sensor hides the end, the start or the most of a turn; scans are 0.1 s apart.
TEST_P(Conventions, KeepTheEndWhereAPartOfTheTurnIsMissing) {
  const Convention& c = GetParam();
  if (c.modulus > 0) return;  // The counter starts again at another scan's end.
  const bool clock = c.offset_s > 1;
  TimeReader reader;
  const double parts[][2] = {{0, 1}, {0, 1}, {0, 0.5}, {0.5, 1}, {0.4, 0.45}, {0, 1}};
  for (int scan = 0; scan < 6; ++scan) {
    const std::vector<double> truth = Part(parts[scan][0], parts[scan][1]);
    std::vector<double> times =
        Written(truth, c.offset_s + (clock ? scan * kTurn_s : 0), c.unit_s, 0);
    ASSERT_TRUE(reader.Read(c.type, kStamp_ns + scan * 100'000'000LL, times));
    ASSERT_EQ(times.size(), truth.size());
    for (size_t i = 0; i < times.size(); ++i) {
      EXPECT_NEAR(times[i], truth[i] - kTurn_s, 1e-6) << scan << " " << i;
    }
  }
}

TEST(TimeReader, TakesASensorThatWasSetToTurnFaster) {
  TimeReader reader;
  std::vector<double> times;
  for (int scan = 0; scan < 200; ++scan) {
    times = Written(Part(0, 1), 0, scan < 5 ? 1 : 2, 0);  // 0.1 s, then 0.05 s.
    ASSERT_TRUE(reader.Read(kFloat32, kStamp_ns, times));
  }
  EXPECT_NEAR(times.back(), 0, 1e-6);
}

TEST(TimeReader, APointWithoutATimeHasThatOfTheOneBefore) {
  TimeReader reader;
  std::vector<double> times = {4294967295.0, 0, 5e7, 4294967295.0, 1e8};
  ASSERT_TRUE(reader.Read(kUint32, kStamp_ns, times));
  EXPECT_THAT(times,
              ::testing::Pointwise(::testing::DoubleNear(1e-9), {-0.1, -0.1, -0.05, -0.05, 0.0}));
  EXPECT_THAT(reader.Description(), HasSubstr("from the start"));
}

TEST(TimeReader, AClockThatStartsAgainStaysOne) {
  TimeReader reader;
  for (int scan = 0; scan < 60; ++scan) {
    std::vector<double> times = Written(Part(0, 1), scan * 0.1, 1e-9, 4294967296.0);
    ASSERT_TRUE(reader.Read(kUint32, kStamp_ns + scan * 100'000'000LL, times));
    if (scan <= 5) continue;
    EXPECT_THAT(reader.Description(), HasSubstr("of a clock")) << scan;
  }
}

// The convention's times of so many scans, one of whose times is `odd`, in every scan from
// `first_odd` on: that point has none, and the others are as they would be.
void ExpectOneOdd(const Convention& c, double odd, int first_odd) {
  SCOPED_TRACE(::testing::Message() << c.name << " " << odd << " from scan " << first_odd);
  const bool clock = c.offset_s > 1;
  TimeReader reader;
  for (int scan = 0; scan < 4; ++scan) {
    const std::vector<double> truth = Part(0, 1);
    std::vector<double> times =
        Written(truth, c.offset_s + (clock ? scan * kTurn_s : 0), c.unit_s, c.modulus);
    const size_t at = 100 + 200 * static_cast<size_t>(scan);
    if (scan >= first_odd) times[at] = odd;
    ASSERT_TRUE(reader.Read(c.type, kStamp_ns + scan * 100'000'000LL, times));
    EXPECT_EQ(reader.last().odd, scan >= first_odd ? 1u : 0u);
    EXPECT_THAT(reader.Description(), HasSubstr(c.said));
    for (size_t i = 0; i < times.size(); ++i) {
      if (scan >= first_odd && i == at) {
        EXPECT_TRUE(std::isnan(times[i]));
      } else {
        ASSERT_NEAR(times[i], truth[i] - kTurn_s, 1e-6) << scan << " " << i;
      }
    }
  }
}

TEST_P(Conventions, AnOddTimeCostsThatPointAlone) {
  const Convention& c = GetParam();
  if (c.modulus > 0) return;  // See below.
  const bool clock = c.offset_s > 1;
  for (const int first_odd : {0, 1, 3}) {
    for (const double odd : {kNoNumber, kInfinite, -kInfinite, 1e300})
      ExpectOneOdd(c, odd, first_odd);
    for (const double off_s : {-3600.0, -3.0, 5.0, 100.0}) {
      ExpectOneOdd(c, (c.offset_s + off_s) / c.unit_s, first_odd);
    }
    if (clock) ExpectOneOdd(c, 0, first_odd);
  }
}

TEST(TimeReader, AnOddTimeDoesNotHideThatACounterStartedAgain) {
  for (const Convention& c : kConventions) {
    if (c.modulus == 0) continue;
    std::vector<double> times = Written(Part(0, 1), c.offset_s, c.unit_s, c.modulus);
    times[500] = kNoNumber;
    TimeReader reader;
    ASSERT_TRUE(reader.Read(c.type, kStamp_ns, times)) << c.name;
    EXPECT_EQ(reader.last().odd, 1u);
    EXPECT_NEAR(times.front(), -kTurn_s, 1e-6) << c.name;
  }
}

// Every so many points have an odd time, in every scan from `first_odd` on.
void ExpectManyOdd(const Convention& c, double odd_s, size_t every, int first_odd) {
  SCOPED_TRACE(::testing::Message()
               << c.name << " " << odd_s << " every " << every << " from scan " << first_odd);
  const bool clock = c.offset_s > 1;
  TimeReader reader;
  for (int scan = 0; scan < 4; ++scan) {
    const std::vector<double> truth = Part(0, 1);
    std::vector<double> times =
        Written(truth, c.offset_s + (clock ? scan * kTurn_s : 0), c.unit_s, c.modulus);
    size_t count = 0;
    for (size_t i = scan < first_odd ? times.size() : 0; i < times.size(); ++i) {
      if (i % every != every / 2) continue;
      times[i] = odd_s / c.unit_s;
      ++count;
    }
    ASSERT_TRUE(reader.Read(c.type, kStamp_ns + scan * 100'000'000LL, times));
    EXPECT_EQ(reader.last().odd, count);
    EXPECT_DOUBLE_EQ(reader.last().unit_s, c.unit_s);
    EXPECT_THAT(reader.Description(), HasSubstr(c.said));
    for (size_t i = 0; i < times.size(); ++i) {
      if (std::isnan(times[i])) continue;
      ASSERT_NEAR(times[i], truth[i] - kTurn_s, 1e-6) << scan << " " << i;
    }
  }
}

TEST_P(Conventions, ManyOddTimesChangeNoUnit) {
  for (const int first_odd : {0, 1, 3}) {
    for (const size_t every : {500u, 20u, 10u, 4u}) {
      for (const double odd_s : {-50.0, -5e-4 - 50, 1e5, 12.5, -1e9}) {
        ExpectManyOdd(GetParam(), odd_s, every, first_odd);
      }
    }
  }
}

TEST_P(Conventions, OddTimesOfAllKindsChangeNoUnit) {
  const Convention& c = GetParam();
  std::mt19937 random(3);
  TimeReader reader;
  const std::vector<double> truth = Part(0, 1);
  std::vector<double> times = Written(truth, c.offset_s, c.unit_s, c.modulus);
  size_t count = 0;
  for (size_t i = 7; i < times.size(); i += 5, ++count) {
    times[i] = -std::pow(10.0, static_cast<double>(random() % 120) / 10) / c.unit_s;
  }
  ASSERT_TRUE(reader.Read(c.type, kStamp_ns, times));
  EXPECT_DOUBLE_EQ(reader.last().unit_s, c.unit_s);
  EXPECT_EQ(reader.last().odd, count);
}

TEST(TimeReader, TimesOfTwoClocksAreNone) {
  std::vector<double> times = Part(0, 1);
  for (size_t i = 0; i < times.size(); i += 2) times[i] += 1000;
  EXPECT_FALSE(TimeReader().Read(kFloat64, kStamp_ns, times));
}

TEST(TimeReader, ScansOfZerosAmongOthersHaveNoTimes) {
  TimeReader reader;
  std::vector<double> times = Part(0, 1);
  ASSERT_TRUE(reader.Read(kFloat32, kStamp_ns, times));
  times.assign(1000, 0.0);
  EXPECT_FALSE(reader.Read(kFloat32, kStamp_ns, times));
  times = Part(0, 1);
  ASSERT_TRUE(reader.Read(kFloat32, kStamp_ns, times));
  EXPECT_NEAR(times[0], -kTurn_s, 1e-6);
}

TEST(TimeReader, ReturnsThatCrowdInAPartOfTheTurnAreNotOdd) {
  // Nine tenths of the returns within a twentieth of the turn, as at a wall before open water.
  std::vector<double> truth;
  for (int i = 0; i < 1000; ++i) truth.push_back(i < 900 ? 0.05 + i * 5e-6 : (i - 900) * 1e-3);
  TimeReader reader;
  for (int scan = 0; scan < 3; ++scan) {
    std::vector<double> times = truth;
    ASSERT_TRUE(reader.Read(kFloat32, kStamp_ns, times));
    EXPECT_EQ(reader.last().odd, 0u);
    EXPECT_NEAR(times[0], 0.05 - 0.099, 1e-9);
  }
}

TEST(TimeReader, MagnitudeTellsTheUnitOfTimesSince1970) {
  // Spans from which the unit cannot be told.
  for (const auto& [unit_s, name] : {std::pair{1e-9, "ns, of a clock"},
                                     {1e-6, "us, of a clock"},
                                     {1e-3, "ms, of a clock"},
                                     {1.0, "s, of a clock"}}) {
    std::vector<double> part = Written(Part(0, 0.08), 1.7e9, unit_s, 0);
    TimeReader reader;
    ASSERT_TRUE(reader.Read(kFloat64, kStamp_ns, part)) << name;
    EXPECT_NEAR(part.front(), -0.08 * kTurn_s, 2e-4) << name;
    EXPECT_DOUBLE_EQ(reader.last().unit_s, unit_s);
  }
  // Nanoseconds since a sensor was switched on, 20 days ago, are not microseconds since 1970.
  std::vector<double> uptime = Written(Part(0, 1), 20 * 86400.0, 1e-9, 0);
  TimeReader reader;
  ASSERT_TRUE(reader.Read(kFloat64, kStamp_ns, uptime));
  EXPECT_DOUBLE_EQ(reader.last().unit_s, 1e-9);
}

TEST(TimeReader, AGivenUnitIsTaken) {
  // 0.08 ms would be a turn of 80 ms in units a thousand times as long.
  std::vector<double> times = {0, 4e4, 8e4};
  EXPECT_FALSE(TimeReader().Read(kUint32, kStamp_ns, times, 1e-9));
  times = {0, 4e6, 8e6};
  ASSERT_TRUE(TimeReader().Read(kFloat32, kStamp_ns, times, 1e-9));
  EXPECT_NEAR(times[0], -8e-3, 1e-12);
}

TEST(TimeReader, AllZeroIsOfOneInstant) {
  for (const size_t points : {1, 3, 1000}) {
    TimeReader reader;
    for (int scan = 0; scan < 3; ++scan) {
      std::vector<double> times(points, 0.0);
      if (points == 1000) times[17] = scan == 1 ? kNoNumber : scan == 2 ? 5.0 : 0.0;
      ASSERT_TRUE(reader.Read(kFloat32, kStamp_ns, times));
      EXPECT_EQ(reader.memory().zero, TimeReader::Zero::kInstant);
      EXPECT_THAT(reader.Description(), HasSubstr("motion-compensated"));
      EXPECT_EQ(times[0], 0);
      EXPECT_EQ(reader.last().odd, points == 1000 && scan > 0 ? 1u : 0u);
    }
    // A sensor whose first scan was empty of times.
    std::vector<double> times = Part(0, 1);
    ASSERT_TRUE(reader.Read(kFloat32, kStamp_ns, times));
    EXPECT_THAT(reader.Description(), HasSubstr("from the start"));
    EXPECT_NEAR(times[0], -kTurn_s, 1e-6);
  }
}

TEST(TimeReader, AnyMixtureGivesTimesWithinAScanOrNone) {
  std::mt19937 random(1);
  const double values[] = {0,      kNoNumber, kInfinite, -kInfinite, 0.05,   5,
                           1e9,    1.7e9,     4e9,       1e12,       1.7e15, 1.7e18,
                           -1e300, 1e8,       -1e-9,     1e300,      3600,   3.6e9};
  for (int trial = 0; trial < 3000; ++trial) {
    TimeReader reader;
    const double base = values[random() % std::size(values)];
    const double step = std::pow(10.0, static_cast<int>(random() % 12) - 6);
    for (int scan = 0; scan < 3; ++scan) {
      std::vector<double> times;
      const size_t points = trial % 5 == 0 ? 1 + random() % 3 : 50;
      const bool mixed = random() % 2 == 0;
      for (size_t i = 0; i < points; ++i) {
        times.push_back(mixed && random() % 3 == 0 ? values[random() % std::size(values)]
                                                   : base + step * static_cast<double>(i));
      }
      if (!reader.Read(kFloat64, kStamp_ns, times)) continue;
      size_t odd = 0;
      for (const double t : times) {
        odd += std::isnan(t) ? 1 : 0;
        ASSERT_TRUE(std::isnan(t) || (t <= 0 && t >= -1.2)) << t;
      }
      EXPECT_EQ(odd, reader.last().odd);
      EXPECT_LT(odd, times.size());
    }
  }
}

TEST(TimeReader, RefusesWhatIsNoTime) {
  const auto read = [](std::vector<double> times) {
    return TimeReader().Read(kFloat64, kStamp_ns, times);
  };
  EXPECT_FALSE(read({}));
  EXPECT_FALSE(read({5, 5, 5}));
  EXPECT_FALSE(read({0.05}));
  EXPECT_FALSE(read(std::vector<double>(1000, kNoNumber)));
  EXPECT_FALSE(read({kInfinite, -kInfinite}));
  std::vector<double> unfilled(1000, 4294967295.0);
  EXPECT_FALSE(TimeReader().Read(kUint32, kStamp_ns, unfilled));
  EXPECT_FALSE(read({-1e300, 1e300}));
  EXPECT_FALSE(read({0, 1, 2, 3}));
}

}  // namespace
}  // namespace isthmus::codec
