#include "floam/localise/localiser.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "tests/floam/building.h"
#include "tests/floam/odometry_drive.h"

namespace isthmus::floam {
namespace {

using testing::AlongTheAxis;
using testing::EndPose;
using testing::MakeScan;
using testing::MapFrom;
using testing::Motion;
using testing::Room;
using testing::Sensor;

std::shared_ptr<const LocalisationMap> MapOf(const Room& room, const Pose& T_map_world = Pose(),
                                             double to_x = 16) {
  auto map = std::make_shared<LocalisationMap>();
  map->Add(MapFrom(room, AlongTheAxis(-16, to_x)), T_map_world);
  return map;
}

// Drives along the axis from x at 0.5 m/s, weaving a little.
Motion DriveFrom(double x) {
  return [x](double time_s) {
    return Pose::FromXyzRpy(x + 0.5 * time_s, 0.4 * std::sin(time_s), 0, 0, 0,
                            0.3 * std::sin(0.7 * time_s));
  };
}

double Apart(const Pose& a, const Pose& b) { return (a.translation() - b.translation()).norm(); }

class LocaliserTest : public ::testing::Test {
 protected:
  LocalisationResult Step(Localiser& localiser, const Room& room, const Motion& motion, int k) {
    const auto result = localiser.Process(MakeScan(room, motion, sensor_, k));
    EXPECT_TRUE(result.ok()) << result.status();
    return result.ok() ? *result : LocalisationResult();
  }
  Pose Truth(const Motion& motion, int k) const { return EndPose(motion, sensor_, k); }

  const Sensor sensor_;
  Localiser localiser_{testing::Vlp16(), OdometryOptions()};
};

TEST_F(LocaliserTest, FindsARobotAndFollowsItToCentimetres) {
  const Room building = testing::ThreeRooms();
  const Pose T_map_world = Pose::FromXyzRpy(100, -40, 2, 0, 0, 1);
  localiser_.SetMap(MapOf(building, T_map_world));
  const Motion motion = DriveFrom(-12);
  int found_at = -1, located = 0;
  for (int k = 0; k < 120; ++k) {
    const LocalisationResult result = Step(localiser_, building, motion, k);
    if (result.status != LocalisationStatus::kLocated) continue;
    if (found_at < 0) found_at = k;
    ++located;
    const Pose truth = T_map_world * Truth(motion, k);
    ASSERT_LT(Apart(result.T_map_sensor, truth), 0.06) << k;
    ASSERT_LT(RotationAngle(result.T_map_sensor.Inverse() * truth), 0.02) << k;
    ASSERT_LT(Apart(result.T_map_odom * result.odometry.T_odom_sensor, result.T_map_sensor), 1e-9);
    // The claim is neither boast nor worthless.
    const double sigma = std::sqrt(result.covariance.topLeftCorner<3, 3>().trace());
    ASSERT_LT(sigma, 0.1) << k;
    ASSERT_LT(Apart(result.T_map_sensor, truth), 5 * sigma) << k;
  }
  EXPECT_GE(found_at, 0);
  EXPECT_LT(found_at, 20) << "two seconds";
  EXPECT_GT(located, 95);
}

TEST_F(LocaliserTest, OfTwinPlacesNeitherIsClaimed) {
  const Room building = testing::SymmetricRooms();
  localiser_.SetMap(MapOf(building));
  bool was_ambiguous = false;
  for (int k = 0; k < 60; ++k) {
    const LocalisationResult result = Step(localiser_, building, DriveFrom(-12), k);
    EXPECT_FALSE(result.has_pose()) << k;
    was_ambiguous |= result.status == LocalisationStatus::kAmbiguous;
  }
  EXPECT_TRUE(was_ambiguous);
}

TEST_F(LocaliserTest, NothingIsClaimedInAStrangeBuilding) {
  localiser_.SetMap(MapOf(testing::ThreeRooms()));
  for (int k = 0; k < 80; ++k) {
    EXPECT_FALSE(Step(localiser_, testing::OtherBuilding(), DriveFrom(-6), k).has_pose()) << k;
  }
}

TEST_F(LocaliserTest, BeyondTheMapThePlaceGrowsUncertainAndTheMapIsNeverAddedTo) {
  const Room building = testing::ThreeRooms();
  const auto map = MapOf(building, Pose(), -8);  // The first room alone.
  const size_t voxels = map->memory()->voxel_count();
  localiser_.SetMap(map);
  const Motion motion = DriveFrom(-12);
  LocalisationResult result;
  bool was_located = false;
  for (int k = 0; k < 360; ++k) {
    result = Step(localiser_, building, motion, k);
    was_located |= result.status == LocalisationStatus::kLocated;
    if (result.has_pose()) {
      ASSERT_LT(Apart(result.T_map_sensor, Truth(motion, k)), 0.2) << k;
    }
  }
  EXPECT_TRUE(was_located);
  EXPECT_NE(result.status, LocalisationStatus::kLocated) << "two rooms on";
  EXPECT_EQ(map->memory()->voxel_count(), voxels);
}

TEST_F(LocaliserTest, ARobotThatWasCarriedIsFoundAnew) {
  const Room building = testing::ThreeRooms();
  localiser_.SetMap(MapOf(building));
  for (int k = 0; k < 30; ++k) Step(localiser_, building, DriveFrom(-14), k);
  int wrong = 0;
  LocalisationResult result;
  for (int k = 30; k < 110; ++k) {
    result = Step(localiser_, building, DriveFrom(6), k);
    const bool located = result.status == LocalisationStatus::kLocated;
    wrong += located && Apart(result.T_map_sensor, Truth(DriveFrom(6), k)) > 0.2;
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(result.status, LocalisationStatus::kLocated);
}

TEST_F(LocaliserTest, WhenTheMapMovesThePlaceMovesWithIt) {
  const Room building = testing::ThreeRooms();
  localiser_.SetMap(MapOf(building));
  const Motion motion = DriveFrom(-12);
  for (int k = 0; k < 30; ++k) Step(localiser_, building, motion, k);
  const Pose T_new_old = Pose::FromXyzRpy(3, -2, 0, 0, 0, 0.5);
  localiser_.SetMap(MapOf(building, T_new_old), T_new_old);
  const LocalisationResult result = Step(localiser_, building, motion, 30);
  EXPECT_EQ(result.status, LocalisationStatus::kLocated);
  EXPECT_LT(Apart(result.T_map_sensor, T_new_old * Truth(motion, 30)), 0.06);
}

TEST_F(LocaliserTest, WithoutAMapItIsOdometryAlone) {
  const LocalisationResult result = Step(localiser_, testing::ThreeRooms(), DriveFrom(-12), 0);
  EXPECT_EQ(result.status, LocalisationStatus::kSearching);
  EXPECT_EQ(result.odometry.segment, 1u);
}

}  // namespace
}  // namespace isthmus::floam
