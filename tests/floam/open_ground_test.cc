// Drives without walls: poles, starts at speed and scans far apart.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "floam/map/pole_search.h"
#include "floam/odometry.h"
#include "floam/odometry_options.h"
#include "floam/scan/features.h"
#include "tests/floam/room.h"

namespace isthmus::floam {
namespace {

using testing::EndPose;
using testing::FurnishedRoom;
using testing::MakeScan;
using testing::Motion;
using testing::Room;
using testing::Sensor;

constexpr double kGroundM = -1.8;

// Level ground out of sight of any wall, posts along both sides of a road: by chance, for what
// comes again after the same way every time tells no speed.
Room OpenRoad() {
  Room room;
  room.walls = {{-900, -900, kGroundM}, {900, 900, 900}};
  std::mt19937 random(5);
  std::uniform_real_distribution<double> next(4, 14), beside(4, 9), wide(0.08, 0.3), tall(1, 4);
  for (const int side : {-1, 1}) {
    for (double x = -60; x < 160; x += next(random)) {
      const double y = side * beside(random), w = wide(random);
      room.boxes.push_back({{x, y, kGroundM}, {x + w, y + w, kGroundM + tall(random)}});
    }
  }
  return room;
}

Features FeaturesOf(const Room& room, const Pose& T_world_sensor, int index = 0) {
  const Motion still = [&](double) { return T_world_sensor; };
  RingScan sorted;
  EXPECT_TRUE(
      RingSorter()
          .Sort(MakeScan(room, still, Sensor(), index), *FindSensorModel("vlp16"), 0.1, &sorted)
          .ok());
  Features features;
  FeatureExtractor(FeatureOptions()).Extract(sorted, &features);
  return features;
}

TEST(Poles, AreWhatIsNarrowAndStandsOut) {
  Room room;  // Empty but for a post, a wall's width of cardboard, and a post against a wall.
  room.boxes = {{{4, 1, -1.2}, {4.2, 1.2, 3.8}},
                {{3, -4, -1.2}, {3.2, -2, 3.8}},
                {{-10, 2, -1.2}, {-9.9, 2.2, 3.8}}};
  const Features features = FeaturesOf(room, Pose());
  ASSERT_GE(features.poles.size(), 10u);  // In most of the 16 rings.
  for (const TimedPoint& pole : features.poles) {
    EXPECT_LT((pole.position.head<2>() - Eigen::Vector2f(4.1F, 1.1F)).norm(), 0.2F);
  }
}

// A mast, a box on the roof, somebody who walks beside: it would be found again wherever the robot
// goes. A thing that reaches farther, or leans on a wall, is not taken for one.
TEST(Features, AreNoneOnWhatMayGoAlong) {
  Room room;
  room.boxes = {{{1.2, 0.5, -1.2}, {1.25, 0.55, 3.8}},    // Slim.
                {{-1.3, -0.4, -1.2}, {-1.1, 0.4, 3.8}}};  // As wide as a person with luggage.
  const auto near = [](const std::vector<TimedPoint>& points) {
    return std::ranges::count_if(
        points, [](const TimedPoint& p) { return p.position.head<2>().norm() < 2.5F; });
  };
  const Features along = FeaturesOf(room, Pose());
  EXPECT_EQ(near(along.surfaces) + near(along.edges) + near(along.poles), 0);
  const Features away = FeaturesOf(room, Pose::FromXyzRpy(3.5, 0, 0, 0, 0, 0));
  const auto on_box = [](const TimedPoint& p) {
    return std::abs(p.position.x() + 4.6F) < 0.15F && std::abs(p.position.y()) < 0.5F;
  };
  EXPECT_GT(std::ranges::count_if(away.surfaces, on_box), 0);
  EXPECT_FALSE(FeaturesOf(room, Pose::FromXyzRpy(0, -3, 0, 0, 0, 0)).poles.empty());
  room.boxes.push_back({{0.5, -9, -1.2}, {0.9, 9, 3.8}});  // A wall that passes by.
  EXPECT_GT(near(FeaturesOf(room, Pose()).surfaces), 0);
}

TEST(Poles, FlakesNearTheSensorAreNone) {
  const Motion still = [](double) { return Pose(); };
  Scan scan = MakeScan(Room(), still, Sensor(), 0);
  for (size_t i = 5; i < scan.points.size(); i += 97) {
    ScanPoint& p = scan.points[i];
    const float nearer = 2 / std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    p.x *= nearer, p.y *= nearer, p.z *= nearer;
  }
  RingScan sorted;
  ASSERT_TRUE(RingSorter().Sort(scan, *FindSensorModel("vlp16"), 0.1, &sorted).ok());
  Features features;
  FeatureExtractor(FeatureOptions()).Extract(sorted, &features);
  EXPECT_TRUE(features.poles.empty());
}

TEST(PoleSearch, FindsMotionsForwardAndInverse) {
  const Room road = OpenRoad();
  for (const Pose& motion : {Pose(), Pose::FromXyzRpy(1.3, 0.1, 0, 0, 0, 0.04),
                             Pose::FromXyzRpy(-0.8, 0, 0, 0, 0, -0.1)}) {
    const Features before = FeaturesOf(road, Pose()), now = FeaturesOf(road, motion, 1);
    const auto there = MotionsOfPoles(before.poles, now.poles, 0.1);
    const auto back = MotionsOfPoles(now.poles, before.poles, 0.1);
    ASSERT_FALSE(there.empty());
    ASSERT_FALSE(back.empty());
    const Pose error = motion.Inverse() * there.front(), inverse = motion * back.front();
    EXPECT_LT(error.translation().norm(), 0.3);
    EXPECT_LT(RotationAngle(error), 0.03);
    EXPECT_LT(inverse.translation().norm(), 0.3);
    EXPECT_LT(RotationAngle(inverse), 0.03);
  }
}

TEST(PoleSearch, SaysNothingOfTooFewPoles) {
  const TimedPoint pole{{5, 0, 0}, 0, 1, 3};
  EXPECT_TRUE(MotionsOfPoles({}, {}, 0.1).empty());
  EXPECT_TRUE(MotionsOfPoles({pole, pole}, {pole, pole}, 0.1).empty());
}

struct GroundOutcome {
  int lost = 0;
  double worst_m = 0, worst_rad = 0;
};

// Every nth scan, from the first, of a motion.
GroundOutcome Follow(const Room& room, const Motion& motion, int scans, int every = 1) {
  OdometryOptions options;
  options.undistort_cloud = false;
  Odometry odometry(*FindSensorModel("vlp16"), options);
  GroundOutcome outcome;
  Pose T_world_odom;
  for (int k = 0; k < scans; k += every) {
    const auto result = odometry.Process(MakeScan(room, motion, Sensor(), k));
    EXPECT_TRUE(result.ok()) << result.status();
    if (!result.ok()) break;
    const Pose truth = EndPose(motion, Sensor(), k);
    if (k == 0) T_world_odom = truth * result->T_odom_sensor.Inverse();
    const Pose error = truth.Inverse() * T_world_odom * result->T_odom_sensor;
    outcome.lost += result->status == TrackingStatus::kLost || result->segment > 1;
    outcome.worst_m = std::max(outcome.worst_m, error.translation().norm());
    outcome.worst_rad = std::max(outcome.worst_rad, RotationAngle(error));
  }
  return outcome;
}

TEST(OpenRoad, IsFollowedFromTheFirstScanAtAnySpeed) {
  const Room road = OpenRoad();
  for (const double speed : {0.0, 3.0, 8.0, 15.0}) {
    for (const double yaw_rate : {0.0, 0.25}) {
      SCOPED_TRACE(::testing::Message() << speed << " m/s, " << yaw_rate << " rad/s");
      const Vector6d twist = (Vector6d() << speed, 0, 0, 0, 0, yaw_rate).finished();
      const GroundOutcome outcome = Follow(
          road, [&](double time_s) { return Exp(time_s * twist); }, 25);
      EXPECT_EQ(outcome.lost, 0);
      EXPECT_LT(outcome.worst_m, 0.2 + 0.005 * 2.5 * speed);
      EXPECT_LT(outcome.worst_rad, 0.02);
    }
  }
}

TEST(OpenRoad, IsFollowedFromStandingWithAcceleration) {
  const GroundOutcome outcome = Follow(
      OpenRoad(),
      [](double time_s) {
        const double moving = std::max(0.0, time_s - 1);
        return Pose(Eigen::Vector3d(1.5 * moving * moving, 0, 0));  // 3 m/s^2.
      },
      45);
  EXPECT_EQ(outcome.lost, 0);
  EXPECT_LT(outcome.worst_m, 0.25);
}

// Turning about a sensor that is mounted at a tilt: in its own frame it rolls and pitches as well.
TEST(OpenRoad, IsFollowedByATiltedSensorThatTurns) {
  const Pose T_base_sensor = Pose::FromXyzRpy(0, 0, 0, 0.1, 0.25, 0.4);
  const GroundOutcome outcome = Follow(
      OpenRoad(),
      [&](double time_s) {
        const double moving = std::max(0.0, time_s - 0.5);
        const double angle = moving < 1 ? 0.5 * moving * moving : moving - 0.5;
        return Pose::FromXyzRpy(0, 0, 0, 0, 0, 0.8 * angle) * T_base_sensor;
      },
      30);
  EXPECT_EQ(outcome.lost, 0);
  EXPECT_LT(outcome.worst_m, 0.2);
  EXPECT_LT(outcome.worst_rad, 0.03);
}

TEST(KeyScans, AreFollowedOverGapsOfSecondsAndMetres) {
  const Motion loop = testing::Loop(1.2);
  const GroundOutcome indoors = Follow(
      FurnishedRoom(), [&](double time_s) { return loop(time_s + 3); }, 160, 10);
  EXPECT_EQ(indoors.lost, 0);
  EXPECT_LT(indoors.worst_m, 0.1);
  const GroundOutcome outdoors = Follow(
      OpenRoad(), [](double time_s) { return Pose(Eigen::Vector3d(4 * time_s, 0, 0)); }, 120, 6);
  EXPECT_EQ(outdoors.lost, 0);
  EXPECT_LT(outdoors.worst_m, 0.3);
}

}  // namespace
}  // namespace isthmus::floam
