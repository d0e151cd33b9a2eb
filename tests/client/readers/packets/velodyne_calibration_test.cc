#include "client/readers/packets/velodyne/velodyne_calibration.h"

#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "client/readers/packets/laser_geometry.h"

namespace isthmus::readers::velodyne {
namespace {

using ::testing::HasSubstr;

Calibration OneLaser(const Laser& laser) {
  Calibration calibration;
  calibration.lasers = {laser};
  return calibration;
}

TEST(VelodyneCalibration, ReadsTheLayoutOfRos) {
  const auto calibration = ParseCalibration(
      "lasers:\n"
      "- {dist_correction: 1.2, dist_correction_x: 1.3, dist_correction_y: 1.4, focal_distance: 10,"
      " focal_slope: 0.5, horiz_offset_correction: 0.026, laser_id: 1, max_intensity: 235,"
      " min_intensity: 30, rot_correction: -0.08, vert_correction: -0.1,"
      " vert_offset_correction: 0.2}\n"
      "- {laser_id: 0, rot_correction: 0.1, vert_correction: 0.2}\n"
      "num_lasers: 2\ndistance_resolution: 0.004\n");
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  ASSERT_EQ(calibration->lasers.size(), 2u);
  EXPECT_EQ(calibration->range_unit_m, 0.004);
  EXPECT_EQ(calibration->lasers[0].rotation, 0.1);
  const Laser& laser = calibration->lasers[1];
  EXPECT_EQ(laser.elevation, -0.1);
  EXPECT_EQ(laser.range_far, 1.2);
  EXPECT_EQ(laser.range_near_y, 1.4);
  EXPECT_TRUE(laser.two_point);
  EXPECT_EQ(laser.horizontal_offset, 0.026);
  EXPECT_EQ(laser.vertical_offset, 0.2);
  EXPECT_EQ(laser.min_intensity, 30);
  EXPECT_EQ(laser.max_intensity, 235);
}

TEST(VelodyneCalibration, SaysWhatIsWrong) {
  for (const auto& [yaml, words] :
       {std::pair("", "no list of lasers"), std::pair("3", "no list"),
        std::pair("lasers: 5", "no list"), std::pair("lasers: []", "there are 0"),
        std::pair("{lasers: [{laser_id: 0}], num_lasers: 2}", "num_lasers is 2"),
        std::pair("lasers: [{laser_id: 0}, {laser_id: 0}]", "twice"),
        std::pair("lasers: [{laser_id: 7}]", "out of range"), std::pair("lasers: [7]", "no map"),
        std::pair("lasers: [{laser_id: 0, vert_correction: up}]", "conversion"),
        std::pair("lasers: [{laser_id: 0, vert_correction: .nan}]", "out of range"),
        std::pair("{lasers: [{laser_id: 0}], distance_resolution: -1}", "distance_resolution"),
        std::pair("lasers: [{", "end of"), std::pair("{a: *b}", "anchor")}) {
    const auto calibration = ParseCalibration(yaml);
    EXPECT_TRUE(absl::IsInvalidArgument(calibration.status())) << yaml;
    EXPECT_THAT(std::string(calibration.status().message()), HasSubstr(words)) << yaml;
  }
}

std::string LasersYaml(int lasers) {
  std::string yaml = absl::StrCat("{num_lasers: ", lasers, ", lasers: [");
  for (int i = 0; i < lasers; ++i) absl::StrAppend(&yaml, "{laser_id: ", i, "}, ");
  return yaml + "]}";
}

TEST(VelodyneCalibration, AVls128HasTheMostLasers) {
  const auto calibration = ParseCalibration(LasersYaml(128));
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  EXPECT_TRUE(CheckCalibration(Model::kVls128, *calibration).ok());
  EXPECT_FALSE(CheckCalibration(Model::kHdl64, *calibration).ok());
  EXPECT_THAT(std::string(ParseCalibration(LasersYaml(129)).status().message()),
              HasSubstr("129 lasers, and no sensor has more than 128"));
}

TEST(LaserGeometry, LaserPointsAtAzimuthLessItsRotation) {
  Laser laser;
  laser.rotation = 0.1;
  laser.elevation = 0.2;
  const auto at = LaserGeometry(OneLaser(laser)).Locate(0, 3000, 5000, 7);
  const double azimuth = 30 * M_PI / 180 - 0.1;
  EXPECT_NEAR(at.x, 10 * std::cos(0.2) * std::cos(azimuth), 1e-5);
  EXPECT_NEAR(at.y, -10 * std::cos(0.2) * std::sin(azimuth), 1e-5);
  EXPECT_NEAR(at.z, 10 * std::sin(0.2), 1e-5);
  EXPECT_EQ(at.intensity, 7);
}

TEST(LaserGeometry, OffsetsMoveTheLaserAcrossItsBeam) {
  Laser laser;
  laser.elevation = 0.3;
  laser.vertical_offset = 0.2;
  laser.horizontal_offset = 0.05;
  const auto at = LaserGeometry(OneLaser(laser)).Locate(0, 0, 5000, 0);
  EXPECT_NEAR(at.x, 10 * std::cos(0.3) - 0.2 * std::sin(0.3), 1e-5);
  EXPECT_NEAR(at.y, 0.05, 1e-5);  // To the left.
  EXPECT_NEAR(at.z, 10 * std::sin(0.3) + 0.2 * std::cos(0.3), 1e-5);
}

TEST(LaserGeometry, NearRangesHaveTheirOwnCorrection) {
  Laser laser;
  laser.range_far = 1.0;
  laser.range_near_x = 1.1;
  laser.range_near_y = 1.2;
  laser.two_point = true;
  const LaserGeometry geometry(OneLaser(laser));
  // Forward is the manual's y: at its near wall the near correction holds, at the far one the far.
  EXPECT_NEAR(geometry.Locate(0, 0, 465, 0).x, 1.93 + 0.2, 2e-3);
  EXPECT_NEAR(geometry.Locate(0, 0, 12020, 0).x, 25.04, 2e-3);
  EXPECT_NEAR(-geometry.Locate(0, 9000, 700, 0).y, 2.4 + 0.1, 2e-3);
  EXPECT_NEAR(-geometry.Locate(0, 9000, 12020, 0).y, 25.04, 2e-3);
}

TEST(LaserGeometry, IntensitiesAreFocusedAndBounded) {
  Laser laser;
  laser.focal_slope = 2;
  laser.min_intensity = 20;
  laser.max_intensity = 90;
  const LaserGeometry geometry(OneLaser(laser));
  EXPECT_EQ(geometry.Locate(0, 0, 1, 0).intensity, 20);
  EXPECT_EQ(geometry.Locate(0, 0, 60000, 50).intensity, 90);
}

TEST(LaserGeometry, AzimuthsMayBeAnyNumber) {
  const LaserGeometry geometry(OneLaser({}));
  for (const double azimuth : {-36000.0, -0.0001, 0.0, 35999.9999, 36000.0, 71999.0}) {
    const auto at = geometry.Locate(0, azimuth, 5000, 0);
    const double angle = azimuth * M_PI / 18000;
    EXPECT_NEAR(at.x, 10 * std::cos(angle), 1e-5) << azimuth;
    EXPECT_NEAR(at.y, -10 * std::sin(angle), 1e-5) << azimuth;
  }
}

}  // namespace
}  // namespace isthmus::readers::velodyne
