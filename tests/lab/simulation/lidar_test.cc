#include "lab/simulation/sensors/lidar.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "core/geometry/angles.h"

namespace isthmus::simulation {
namespace {

double Azimuth(const Firing& firing) {
  return std::atan2(firing.direction.y(), firing.direction.x());
}
double Elevation(const Firing& firing) { return std::asin(firing.direction.z()); }

std::vector<std::string> Names(bool spinning) {
  std::vector<std::string> names;
  for (const std::string& name : LidarNames()) {
    if (MakeLidar(name)->has_rings == spinning) names.push_back(name);
  }
  return names;
}

std::string TestName(const ::testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

class EveryLidar : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryLidar, FiresInOrderOfTimeInGroups) {
  const Lidar lidar = *MakeLidar(GetParam());
  EXPECT_EQ(lidar.name, GetParam());
  ASSERT_EQ(lidar.firings.size() % lidar.lasers, 0u);
  const double group_s = lidar.period_s * static_cast<double>(lidar.lasers) /
                         static_cast<double>(lidar.firings.size());
  EXPECT_LT(group_s, 1.1e-4);  // Motion is taken to be linear meanwhile.
  double before = -1;
  for (size_t i = 0; i < lidar.firings.size(); ++i) {
    const Firing& firing = lidar.firings[i];
    ASSERT_GE(firing.time_s, before);
    ASSERT_LT(firing.time_s, lidar.period_s);
    ASSERT_NEAR(firing.time_s, group_s * (0.5 + static_cast<double>(i / lidar.lasers)), group_s);
    ASSERT_NEAR(firing.direction.norm(), 1, 1e-6);
    before = firing.time_s;
  }
}

INSTANTIATE_TEST_SUITE_P(Models, EveryLidar, ::testing::ValuesIn(LidarNames()), TestName);

class SpinningLidar : public ::testing::TestWithParam<std::string> {};

TEST_P(SpinningLidar, FiresOnceAroundClockwiseFromTheBack) {
  const Lidar lidar = *MakeLidar(GetParam());
  const auto azimuth = [&](double share) {
    const auto i = static_cast<size_t>(share * static_cast<double>(lidar.firings.size()));
    return Azimuth(lidar.firings[i]);
  };
  EXPECT_NEAR(std::abs(azimuth(0)), std::numbers::pi, 0.01);
  EXPECT_NEAR(azimuth(0.25), std::numbers::pi / 2, 0.02);  // Left first: clockwise from the back.
  EXPECT_NEAR(azimuth(0.5), 0, 0.02);
  EXPECT_NEAR(azimuth(0.75), -std::numbers::pi / 2, 0.02);
}

TEST_P(SpinningLidar, RingsAscendFromTheLowest) {
  const Lidar lidar = *MakeLidar(GetParam());
  std::map<uint16_t, float> height;
  for (size_t i = 0; i < lidar.lasers; ++i) {
    height[lidar.firings[i].ring] = lidar.firings[i].direction.z();
  }
  ASSERT_EQ(height.size(), lidar.lasers);
  EXPECT_EQ(height.begin()->first, 0);
  float before = -1;
  for (const auto& [ring, z] : height) {
    EXPECT_GT(z, before) << ring;
    before = z;
  }
}

TEST_P(SpinningLidar, RepeatsItsPattern) {
  const Lidar lidar = *MakeLidar(GetParam());
  const std::vector<Firing> later = AtScan(lidar, 7).firings;
  ASSERT_EQ(later.size(), lidar.firings.size());
  for (size_t i = 0; i < later.size(); ++i) {
    ASSERT_EQ(later[i].direction, lidar.firings[i].direction);
  }
}

INSTANTIATE_TEST_SUITE_P(Models, SpinningLidar, ::testing::ValuesIn(Names(true)), TestName);

TEST(Lidar, Vlp16IsAsInItsManual) {
  const Lidar lidar = *MakeLidar("vlp16");
  EXPECT_EQ(lidar.firings.size(), 1808u * 16);
  EXPECT_NEAR(std::asin(lidar.firings[0].direction.z()) * 180 / std::numbers::pi, -15, 1e-4);
  EXPECT_NEAR(std::asin(lidar.firings[1].direction.z()) * 180 / std::numbers::pi, 1, 1e-4);
  EXPECT_DOUBLE_EQ(lidar.firings[17].time_s, 55.296e-6 + 2.304e-6);
}

TEST(Lidar, Vlp32LooksClosestAroundTheHorizon) {
  const Lidar lidar = *MakeLidar("vlp32");
  std::vector<double> elevations(32);
  for (size_t i = 0; i < 32; ++i) {
    elevations[lidar.firings[i].ring] = Elevation(lidar.firings[i]) / kRadPerDeg;
  }
  EXPECT_NEAR(elevations[0], -25, 1e-3);
  EXPECT_NEAR(elevations[20], 0, 1e-3);
  EXPECT_NEAR(elevations[31], 15, 1e-3);
  for (int ring = 9; ring < 26; ++ring) {
    EXPECT_NEAR(elevations[ring] - elevations[ring - 1], 1.0 / 3, 2e-3) << ring;
  }
}

TEST(Lidar, SolidLooksAheadRowByRow) {
  const Lidar lidar = *MakeLidar("solid");
  EXPECT_FALSE(lidar.has_rings);
  ASSERT_EQ(lidar.firings.size(), 24000u);
  for (size_t i = 0; i < lidar.firings.size(); ++i) {
    const Firing& firing = lidar.firings[i];
    ASSERT_LT(std::abs(Azimuth(firing)), 60.01 * kRadPerDeg);
    ASSERT_LT(std::abs(Elevation(firing)), 45.01 * kRadPerDeg);
    if (i == 0) continue;
    const Firing& before = lidar.firings[i - 1];
    if (i % 240 == 0) {
      ASSERT_LT(Elevation(firing), Elevation(before) - 0.5 * kRadPerDeg);
    } else {
      ASSERT_NEAR(Elevation(firing), Elevation(before), 1e-5);
      ASSERT_LT(Azimuth(firing), Azimuth(before));
    }
  }
}

// Cells of 3 degrees or so that a scan, or the given part of it, looks into.
std::set<std::pair<int, int>> Cells(const std::vector<Firing>& firings, size_t begin, size_t end) {
  std::set<std::pair<int, int>> cells;
  for (size_t i = begin; i < end; ++i) {
    cells.emplace(std::lround(Azimuth(firings[i]) / (3 * kRadPerDeg)),
                  std::lround(Elevation(firings[i]) / (3 * kRadPerDeg)));
  }
  return cells;
}

TEST(Lidar, Mid360LooksAllRoundAtAnyTime) {
  const Lidar lidar = *MakeLidar("mid360");
  ASSERT_EQ(lidar.firings.size(), 20000u);
  for (const Firing& firing : lidar.firings) {
    ASSERT_GT(Elevation(firing), -7.01 * kRadPerDeg);
    ASSERT_LT(Elevation(firing), 52.01 * kRadPerDeg);
  }
  const size_t all = Cells(lidar.firings, 0, 20000).size();
  EXPECT_GT(all, 2300u);
  for (const size_t begin : {0, 7000, 15000}) {
    EXPECT_GT(Cells(lidar.firings, begin, begin + 5000).size(), 9 * all / 10);
  }
}

TEST(Lidar, Mid70LooksAheadAlongARosette) {
  const Lidar lidar = *MakeLidar("mid70");
  double widest = 0;
  for (size_t i = 0; i < lidar.firings.size(); ++i) {
    const Eigen::Vector3f& direction = lidar.firings[i].direction;
    widest = std::max(widest, std::acos(std::min(1.0, double{direction.x()})));
    if (i == 0) continue;
    ASSERT_LT((direction - lidar.firings[i - 1].direction).norm(), 0.6 * kRadPerDeg);
  }
  EXPECT_NEAR(widest, 35.2 * kRadPerDeg, 0.2 * kRadPerDeg);
}

TEST(Lidar, NonRepeatingPatternsFillWhatOneScanLeavesOut) {
  for (const std::string name : {"mid360", "mid70"}) {
    const Lidar lidar = *MakeLidar(name);
    const auto pixels = [&](const std::vector<Firing>& firings) {
      std::set<std::pair<int, int>> cells;
      for (const Firing& f : firings) {
        const Eigen::Vector3f& d = f.direction;
        const double across = d.x() > 0 ? d.y() : d.y() + 3;  // Ahead and behind apart.
        cells.emplace(std::lround(across / 0.01), std::lround(d.z() / 0.01));
      }
      return cells;
    };
    std::set<std::pair<int, int>> seen;
    for (int index = 0; index < 10; ++index) {
      const auto more = pixels(AtScan(lidar, index).firings);
      seen.insert(more.begin(), more.end());
    }
    EXPECT_GT(seen.size(), 2 * pixels(lidar.firings).size()) << name;
  }
}

TEST(Lidar, UnknownModelListsTheKnownOnes) {
  const auto lidar = MakeLidar("radar");
  EXPECT_EQ(lidar.status().code(), absl::StatusCode::kInvalidArgument);
  for (const std::string& name : LidarNames()) {
    EXPECT_NE(std::string(lidar.status().message()).find(name), std::string::npos);
  }
}

}  // namespace
}  // namespace isthmus::simulation
