#include "core/codec/point_times.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace isthmus::codec {
namespace {

using ::testing::HasSubstr;
using enum ScalarType;

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
  if (c.modulus > 0) return;  // Where the counter starts again is another scan's end.
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

TEST(TimeReader, RefusesWhatIsNoTime) {
  const auto read = [](std::vector<double> times) {
    return TimeReader().Read(kFloat64, kStamp_ns, times);
  };
  EXPECT_FALSE(read({}));
  EXPECT_FALSE(read({0, 0, 0}));
  EXPECT_FALSE(read({0, 0.05, std::numeric_limits<double>::quiet_NaN()}));
  EXPECT_FALSE(read({0, 0.05, std::numeric_limits<double>::infinity()}));
  EXPECT_FALSE(read({-1e300, 1e300}));
  EXPECT_FALSE(read({0, 1, 2, 3}));
}

}  // namespace
}  // namespace isthmus::codec
