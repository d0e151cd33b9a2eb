// Anchors of a drive whose way over the Earth is known.
#include "client/georeference/anchors_of_fixes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "client/georeference/limits.h"
#include "core/earth/site.h"

namespace isthmus::georeference {
namespace {

constexpr int64_t kStart = 1'700'000'000'000'000'000, kSecond = 1'000'000'000;
constexpr Datum kDatum{.latitude_deg = 48.137, .longitude_deg = 11.575, .altitude_m = 520};

// A robot that goes east at 2 m/s from the datum.
readers::GnssFix FixAfter(double seconds, double sigma = 0.1) {
  const earth::Geodetic place = earth::Site::Create(kDatum)->ToGeodetic({2 * seconds, 0, 0});
  return {.stamp_ns = kStart + static_cast<int64_t>(seconds * 1e9),
          .latitude_deg = place.latitude_deg,
          .longitude_deg = place.longitude_deg,
          .altitude_m = place.altitude_m,
          .sigma_east_m = sigma,
          .sigma_north_m = sigma / 2,
          .sigma_up_m = 2 * sigma,
          .frame = "gps"};
}

SubmapInfo SubmapFrom(uint32_t index, double seconds) {
  SubmapInfo info;
  info.id = {SessionId("alice-1"), index};
  info.first_stamp_ns = kStart + static_cast<int64_t>(seconds * 1e9);
  info.last_stamp_ns = info.first_stamp_ns + 5 * kSecond;
  return info;
}

TEST(AnchorsOfFixes, ASubmapLiesWhereItWasBegun) {
  const auto made = AnchorsOfFixes({FixAfter(0), FixAfter(1), FixAfter(2)},
                                   {SubmapFrom(0, 0), SubmapFrom(1, 1.25)}, kDatum);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_FALSE(made->is_new_datum);
  ASSERT_EQ(made->anchors.size(), 2u);
  EXPECT_EQ(made->anchors[1].submap.index, 1u);
  EXPECT_LT((made->anchors[0].T_map_submap.translation() - Eigen::Vector3d(0, 0, 0)).norm(), 1e-6);
  EXPECT_LT((made->anchors[1].T_map_submap.translation() - Eigen::Vector3d(2.5, 0, 0)).norm(), 1e-5)
      << "between the fixes";
  EXPECT_NEAR(made->anchors[1].sigma_xy_m, 0.1, 1e-12) << "the larger of east and north";
  EXPECT_NEAR(made->anchors[1].sigma_z_m, 0.2, 1e-12);
  EXPECT_EQ(made->anchors[1].sigma_deg, 0) << "a fix knows no rotation";
}

TEST(AnchorsOfFixes, SubmapsWithoutFixesHaveNoAnchor) {
  const auto made =
      AnchorsOfFixes({FixAfter(0), FixAfter(1), FixAfter(60)},
                     {SubmapFrom(0, 0.5), SubmapFrom(1, 30), SubmapFrom(2, 61)}, kDatum);
  ASSERT_TRUE(made.ok());
  ASSERT_EQ(made->anchors.size(), 2u);
  EXPECT_EQ(made->anchors[0].submap.index, 0u);
  EXPECT_EQ(made->anchors[1].submap.index, 2u) << "by the fix a second before";
  EXPECT_NEAR(made->anchors[1].sigma_xy_m, std::hypot(0.1, kDriftMps), 1e-9);
}

TEST(AnchorsOfFixes, TheFirstFixBecomesTheDatumWhereThereIsNone) {
  const auto made = AnchorsOfFixes({FixAfter(5), FixAfter(3), FixAfter(4)}, {SubmapFrom(0, 4)}, {});
  ASSERT_TRUE(made.ok());
  EXPECT_TRUE(made->is_new_datum);
  EXPECT_EQ(made->datum.latitude_deg, FixAfter(3).latitude_deg);
  EXPECT_EQ(made->datum.heading_deg, 0);
  ASSERT_EQ(made->anchors.size(), 1u);
  EXPECT_NEAR(made->anchors[0].T_map_submap.translation().x(), 2, 1e-5);
}

// A robot that starts facing north, goes north and then east, with the antenna 1 m behind the LiDAR
// and 0.5 m above it.
struct OffAntenna : testing::Test {
  static constexpr double kStepM = 10;
  const Antenna antenna{.in_sensor = {-1, 0, 0.5}};

  // The sensor after so many steps, of which the first four lead north.
  static Pose InMap(int step) {
    const double half_turn = std::numbers::pi / 2;
    return step < 4 ? Pose::FromXyzRpy(0, kStepM * step, 0, 0, 0, half_turn)
                    : Pose::FromXyzRpy(kStepM * (step - 3), 3 * kStepM, 0, 0, 0, 0);
  }
  void Drive(int steps) {
    const earth::Site site = *earth::Site::Create(kDatum);
    for (int step = 0; step < steps; ++step) {
      readers::GnssFix fix = FixAfter(step);
      const earth::Geodetic at = site.ToGeodetic(InMap(step) * antenna.in_sensor);
      fix.latitude_deg = at.latitude_deg;
      fix.longitude_deg = at.longitude_deg;
      fix.altitude_m = at.altitude_m;
      fixes.push_back(fix);
      submaps.push_back(SubmapFrom(step, step));
      submaps.back().T_odom_submap = InMap(0).Inverse() * InMap(step);
    }
  }
  std::vector<readers::GnssFix> fixes;
  std::vector<SubmapInfo> submaps;
};

TEST_F(OffAntenna, IsTakenOutOnceTheWayTellsTheHeading) {
  Drive(8);
  const auto made = AnchorsOfFixes(fixes, submaps, kDatum, antenna);
  ASSERT_EQ(made->anchors.size(), 8u);
  for (int step = 0; step < 8; ++step) {
    const Anchor& anchor = made->anchors[step];
    EXPECT_LT((anchor.T_map_submap.translation() - InMap(step).translation()).norm(), 1e-3) << step;
    EXPECT_LT(anchor.sigma_xy_m, 0.15) << "little more than the fix";
    EXPECT_GT(anchor.sigma_xy_m, 0.1);
  }
}

TEST_F(OffAntenna, WithoutAHeadingItsHeightIsTakenOutAndTheRestIsInTheSigma) {
  Drive(1);
  const auto made = AnchorsOfFixes(fixes, submaps, kDatum, antenna);
  ASSERT_EQ(made->anchors.size(), 1u);
  const Anchor& anchor = made->anchors[0];
  EXPECT_NEAR(anchor.T_map_submap.translation().z(), 0, 1e-6);
  EXPECT_NEAR(anchor.T_map_submap.translation().y(), -1, 1e-5) << "the antenna's";
  EXPECT_NEAR(anchor.sigma_xy_m, std::hypot(0.1, 1), 1e-9);
}

TEST_F(OffAntenna, WildFixesAnchorNothing) {
  Drive(8);
  const earth::Site site = *earth::Site::Create(kDatum);
  for (const auto& [step, off] : {std::pair(2, 5000.0), std::pair(6, -60.0)}) {
    const earth::Geodetic at =
        site.ToGeodetic(InMap(step) * antenna.in_sensor + off * Eigen::Vector3d::UnitX());
    fixes[step].latitude_deg = at.latitude_deg;
    fixes[step].longitude_deg = at.longitude_deg;
  }
  const auto made = AnchorsOfFixes(fixes, submaps, kDatum, antenna);
  EXPECT_EQ(made->wild, 2);
  ASSERT_EQ(made->anchors.size(), 6u);
  for (const Anchor& anchor : made->anchors) {
    const int step = static_cast<int>(anchor.submap.index);
    EXPECT_NE(step, 2);
    EXPECT_NE(step, 6);
    EXPECT_LT((anchor.T_map_submap.translation() - InMap(step).translation()).norm(), 0.05) << step;
  }
}

TEST_F(OffAntenna, OnATiltedLidarIsTakenOutOnTheLevel) {
  Drive(8);
  // The LiDAR looks 40 degrees down; the antenna stays where it is on the robot.
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY()));
  const Pose mount(tilt, Eigen::Vector3d::Zero());
  for (SubmapInfo& submap : submaps) {
    submap.T_odom_submap = mount.Inverse() * submap.T_odom_submap * mount;
  }
  const Antenna tilted{.in_sensor = tilt.inverse() * antenna.in_sensor, .R_base_sensor = tilt};
  const auto made = AnchorsOfFixes(fixes, submaps, kDatum, tilted);
  ASSERT_EQ(made->anchors.size(), 8u);
  for (int step = 0; step < 8; ++step) {
    const Eigen::Vector3d at = made->anchors[step].T_map_submap.translation();
    EXPECT_LT((at - InMap(step).translation()).norm(), 1e-3) << step;
  }
}

TEST(AnchorsOfFixes, AFixThatStatesNoSigmaIsHardlyBelieved) {
  const auto made = AnchorsOfFixes({FixAfter(0, 0)}, {SubmapFrom(0, 0)}, kDatum);
  ASSERT_TRUE(made.ok());
  EXPECT_EQ(made->anchors.at(0).sigma_xy_m, kUnknownSigmaXyM);
  EXPECT_EQ(made->anchors.at(0).sigma_z_m, kUnknownSigmaZM);
  const auto exact = AnchorsOfFixes({FixAfter(0, 1e-9)}, {SubmapFrom(0, 0)}, kDatum);
  EXPECT_EQ(exact->anchors.at(0).sigma_xy_m, kLeastSigmaM);
}

TEST(AnchorsOfFixes, WhatCannotBeUsedIsSaid) {
  EXPECT_TRUE(absl::IsNotFound(AnchorsOfFixes({}, {SubmapFrom(0, 0)}, kDatum).status()));
  readers::GnssFix wrong = FixAfter(0);
  wrong.latitude_deg = 100;
  EXPECT_TRUE(absl::IsInvalidArgument(AnchorsOfFixes({wrong}, {}, kDatum).status()));
  Datum elsewhere = kDatum;
  elsewhere.latitude_deg = 47;
  const auto far = AnchorsOfFixes({FixAfter(0)}, {SubmapFrom(0, 0)}, elsewhere);
  ASSERT_TRUE(far.ok());
  EXPECT_TRUE(far->anchors.empty()) << "farther than an anchor may lie";
}

}  // namespace
}  // namespace isthmus::georeference
