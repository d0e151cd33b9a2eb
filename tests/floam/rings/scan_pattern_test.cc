#include "floam/rings/scan_pattern.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "tests/floam/room.h"

namespace isthmus::floam {
namespace {

using testing::FurnishedRoom;
using ::testing::HasSubstr;
using testing::MakeScan;
using testing::Sensor;
using testing::Still;

constexpr double kDegree = M_PI / 180;

SensorModel Model(const std::string& name) { return FindSensorModel(name).value(); }

absl::Status Sort(const Scan& scan, const std::string& sensor = "spinning") {
  RingScan sorted;
  return RingSorter().Sort(scan, Model(sensor), 0.1, &sorted);
}

// The direction of a sensor at fraction `f` of a scan: azimuth and elevation.
using Pattern = std::function<std::pair<double, double>(double f)>;

// Points of a sensor with `lines` lasers that all follow the pattern, each a little later.
Scan ScanOfPattern(const Pattern& pattern, int lines, int points) {
  Scan scan;
  scan.sequence = 7;
  scan.end_stamp_ns = 1'000'000'000;
  scan.has_time = true;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.02);
  for (int i = 0; i < points; ++i) {
    const int line = i % lines;
    const double fraction = static_cast<double>(i) / points;
    const auto [azimuth, elevation] = pattern(fraction + 0.003 * line);
    const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                    std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    const double range = FurnishedRoom().Cast(Eigen::Vector3d(-2, 1, 0), direction);
    const Eigen::Vector3f p = ((range + noise(random)) * direction).cast<float>();
    scan.points.push_back({p.x(), p.y(), p.z(), 1, static_cast<float>(0.1 * (fraction - 1)),
                           static_cast<uint16_t>(line)});
  }
  return scan;
}

// Two prisms that turn at rates without a common measure: Livox Mid-40, Avia.
std::pair<double, double> Rosette(double f) {
  const double a = 2 * M_PI * 120.3 * f, b = -2 * M_PI * 77.1 * f;
  return {19 * kDegree * (std::cos(a) + std::cos(b)), 19 * kDegree * (std::sin(a) + std::sin(b))};
}

// All around, elevation to and fro: Livox Mid-360.
std::pair<double, double> Weave(double f) {
  return {std::remainder(2 * M_PI * 10.3 * f, 2 * M_PI),
          (22 + 29 * std::sin(2 * M_PI * 173.7 * f)) * kDegree};
}

// Elevation and azimuth to and fro over a window: Livox Horizon and other mirrors.
std::pair<double, double> Window(double f) {
  return {40 * kDegree * std::sin(2 * M_PI * 5.2 * f),
          12 * kDegree * std::sin(2 * M_PI * 211.7 * f)};
}

TEST(ScanPattern, PatternsThatDoNotRepeatAreNotThoseOfASensorWithRings) {
  for (const Pattern& pattern : {Pattern(Rosette), Pattern(Weave), Pattern(Window)}) {
    for (const int lines : {1, 4, 6}) {
      for (const bool with_line : {true, false}) {
        for (const char* sensor : {"vlp16", "os1-128"}) {
          Scan scan = ScanOfPattern(pattern, lines, 20000);
          scan.has_ring = with_line;
          const absl::Status status = Sort(scan, sensor);
          ASSERT_EQ(status.code(), absl::StatusCode::kInvalidArgument)
              << lines << with_line << sensor;
          EXPECT_THAT(std::string(status.message()), HasSubstr("non-repetitive scan pattern"));
          EXPECT_THAT(std::string(status.message()), HasSubstr("\"unordered\""));
        }
      }
    }
  }
}

TEST(ScanPattern, PatternsThatDoNotRepeatAreTakenWithoutRings) {
  for (const Pattern& pattern : {Pattern(Rosette), Pattern(Weave), Pattern(Window)}) {
    for (const int lines : {1, 4, 6}) {
      for (const bool with_line : {true, false}) {
        for (const char* sensor : {"spinning", "unordered", "mid360", "livox"}) {
          Scan scan = ScanOfPattern(pattern, lines, 20000);
          scan.has_ring = with_line;
          RingSorter sorter;
          RingScan sorted;
          for (int k = 0; k < 3; ++k) {
            const absl::Status status = sorter.Sort(scan, Model(sensor), 0.1, &sorted);
            ASSERT_TRUE(status.ok()) << status << lines << with_line << sensor;
            EXPECT_FALSE(sorted.in_rings());
            EXPECT_EQ(sorted.points.size(), scan.points.size());
            EXPECT_EQ(sorted.times_from, Inference::kSensor);
            EXPECT_EQ(sorted.text.rings, "none: surfaces from neighbourhoods");
            EXPECT_EQ(sorted.text.times, "given");
          }
        }
      }
    }
  }
}

TEST(ScanPattern, BandsOfElevationTakeThePlaceOfRings) {
  RingScan sorted;
  ASSERT_TRUE(
      RingSorter().Sort(ScanOfPattern(Weave, 4, 20000), Model("mid360"), 0.1, &sorted).ok());
  ASSERT_EQ(sorted.ring_begin.back(), sorted.points.size());
  for (size_t band = 0; band + 1 < sorted.ring_begin.size(); ++band) {
    for (uint32_t i = sorted.ring_begin[band]; i < sorted.ring_begin[band + 1]; ++i) {
      const RingPoint& p = sorted.points[i];
      const double above = std::asin(p.z / p.range) + M_PI / 2;
      ASSERT_NEAR(above / kBandRad, static_cast<double>(band) + 0.5, 0.501);
    }
  }
}

TEST(ScanPattern, WithoutRingsOrTimesAllIsTakenToBeOfTheEnd) {
  Scan scan = ScanOfPattern(Rosette, 1, 20000);
  for (const bool compensated : {true, false}) {
    scan.has_time = compensated;
    for (ScanPoint& p : scan.points) p.time = 0;
    RingScan sorted;
    ASSERT_TRUE(RingSorter().Sort(scan, Model("avia"), 0.1, &sorted).ok());
    EXPECT_EQ(sorted.is_compensated, compensated);
    EXPECT_EQ(sorted.times_from, compensated ? Inference::kSensor : Inference::kNone);
    EXPECT_EQ(sorted.text.times,
              compensated ? "given" : "not given: motion within a scan is not compensated");
    for (const RingPoint& p : sorted.points) ASSERT_EQ(p.time, 0);
    EXPECT_DOUBLE_EQ(sorted.period_s, 0.1);
  }
}

TEST(ScanPattern, RefusalOutlastsTheFirstScan) {
  RingSorter sorter;
  RingScan sorted;
  Scan scan = ScanOfPattern(Weave, 4, 20000);
  scan.has_ring = false;
  for (int k = 0; k < 5; ++k) EXPECT_FALSE(sorter.Sort(scan, Model("vlp16"), 0.1, &sorted).ok());
}

struct Spinner {
  const char* name;
  int rings, columns;
  double lowest_deg, highest_deg;
};

const Spinner kSpinners[] = {
    {"Vlp16", 16, 1800, -15, 15},        {"Hdl32", 32, 1800, -30.67, 10.67},
    {"Hdl64", 64, 2000, -24.8, 2},       {"Os0x128", 128, 1024, -45, 45},
    {"Os1x128", 128, 1024, -22.5, 22.5}, {"Os1x64", 64, 512, -22.5, 22.5},
};

class Spinners : public ::testing::TestWithParam<Spinner> {
 protected:
  Scan MakeOne() const {
    Sensor sensor;
    sensor.rings = GetParam().rings;
    sensor.columns = GetParam().columns;
    sensor.lowest_rad = GetParam().lowest_deg * kDegree;
    sensor.highest_rad = GetParam().highest_deg * kDegree;
    return MakeScan(FurnishedRoom(), Still, sensor, 0);
  }
  // The number of rings that come out without any field.
  int RingsOf(Scan scan) const {
    scan.has_ring = scan.has_time = false;
    RingScan sorted;
    const absl::Status status = RingSorter().Sort(scan, Model("spinning"), 0.1, &sorted);
    EXPECT_TRUE(status.ok()) << status;
    return static_cast<int>(sorted.ring_begin.size()) - 1;
  }
};

INSTANTIATE_TEST_SUITE_P(All, Spinners, ::testing::ValuesIn(kSpinners),
                         [](const auto& param) { return param.param.name; });

TEST_P(Spinners, AreTakenWithFields) {
  Scan scan = MakeOne();
  EXPECT_TRUE(Sort(scan).ok());
  // In another order.
  std::shuffle(scan.points.begin(), scan.points.end(), std::mt19937(3));
  EXPECT_TRUE(Sort(scan).ok());
}

TEST_P(Spinners, AreTakenWithoutFields) {
  const Scan scan = MakeOne();
  EXPECT_EQ(RingsOf(scan), GetParam().rings);
  Scan ring_by_ring = scan;
  std::stable_sort(ring_by_ring.points.begin(), ring_by_ring.points.end(),
                   [](const ScanPoint& a, const ScanPoint& b) { return a.ring < b.ring; });
  EXPECT_EQ(RingsOf(ring_by_ring), GetParam().rings);
}

// Lasers are some hundredths of a degree off from turn to turn.
TEST_P(Spinners, AreTakenWithNoisyElevations) {
  Scan scan = MakeOne();
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0, static_cast<float>(0.03 * kDegree));
  for (ScanPoint& p : scan.points) p.z += std::hypot(p.x, p.y) * noise(random);
  EXPECT_TRUE(Sort(scan).ok());
  EXPECT_EQ(RingsOf(scan), GetParam().rings);
}

TEST_P(Spinners, AreTakenTwoReturnsAtATime) {
  Scan scan = MakeOne();
  std::vector<ScanPoint> both;
  for (const ScanPoint& p : scan.points) {
    both.push_back(p);
    both.push_back(p);
    both.back().x *= 0.7F, both.back().y *= 0.7F, both.back().z *= 0.7F;
  }
  const size_t once = scan.points.size();
  scan.points = both;
  RingScan sorted;
  ASSERT_TRUE(RingSorter().Sort(scan, Model("spinning"), 0.1, &sorted).ok());
  EXPECT_EQ(sorted.points.size(), once) << "the farther ones";
}

// Points in the frame of a robot on which the sensor is tilted.
TEST_P(Spinners, AreTakenTiltedWhenRingsAreGiven) {
  Scan scan = MakeOne();
  const Eigen::Matrix3f R = Eigen::AngleAxisf(0.5F, Eigen::Vector3f::UnitY()).matrix();
  for (ScanPoint& p : scan.points) {
    const Eigen::Vector3f q = R * Eigen::Vector3f(p.x, p.y, p.z) + Eigen::Vector3f(0.1F, 0, 0.3F);
    p.x = q.x(), p.y = q.y(), p.z = q.z();
  }
  EXPECT_TRUE(Sort(scan).ok());
}

TEST_P(Spinners, AreRefusedUnderTheNameOfOneWithFewerRings) {
  if (GetParam().rings <= 32) return;
  for (const bool fields : {true, false}) {
    Scan scan = MakeOne();
    scan.has_ring = fields;
    const absl::Status status = Sort(scan, "hdl32");
    ASSERT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(status.message()), HasSubstr("a hdl32 has 32"));
  }
}

TEST(ScanPattern, ElevationsOfAnotherSensorAreSaid) {
  RingScan sorted;
  Sensor sensor;
  sensor.lowest_rad = -0.4;
  const Scan scan = MakeScan(FurnishedRoom(), Still, sensor, 0);
  ASSERT_TRUE(RingSorter().Sort(scan, Model("vlp16"), 0.1, &sorted).ok());
  EXPECT_THAT(sorted.text.warning, HasSubstr("elevations are -23 to 15 deg, but a vlp16"));
}

}  // namespace
}  // namespace isthmus::floam
