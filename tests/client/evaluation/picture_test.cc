#include "client/evaluation/picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

namespace isthmus::evaluation {
namespace {

constexpr Color kWhite{255, 255, 255};

Box Extent(double x0, double y0, double x1, double y1) {
  Box box;
  box.Extend(Eigen::Vector3d(x0, y0, 0));
  box.Extend(Eigen::Vector3d(x1, y1, 3));
  return box;
}

// A wall of points from floor to 3 m at one place.
std::vector<MapPoint> Post(float x, float y, uint32_t robot) {
  std::vector<MapPoint> points;
  for (float z = 0.1f; z < 3; z += 0.1f) points.push_back({x, y, z, 0, robot});
  return points;
}

TopDownPicture Make(const PictureOptions& options = {}) {
  return *TopDownPicture::Create(Extent(-10, -5, 10, 5), {"alice", "bob"}, options);
}

PictureOptions Small() {
  PictureOptions options;
  options.max_side_px = 400;
  options.legend = options.grid = false;
  return options;
}

TEST(TopDownPicture, SizeFollowsTheExtent) {
  const TopDownPicture picture = Make(Small());
  EXPECT_EQ(picture.width(), 400);
  EXPECT_EQ(picture.height(), 200);
  EXPECT_DOUBLE_EQ(picture.meters_per_pixel(), 0.05);
  EXPECT_EQ(picture.Draw().height(), 200);
  PictureOptions legend = Small();
  legend.legend = true;
  EXPECT_GT(Make(legend).Draw().height(), 200);  // Below the map, not on it.
}

TEST(TopDownPicture, PointsLieWhereTheyShouldInTheirRobotsColour) {
  TopDownPicture picture = Make(Small());
  picture.Add(Post(5.02f, 2.52f, 0));
  picture.Add(Post(-5.02f, -2.52f, 1));
  const Canvas canvas = picture.Draw();
  // x to the right, y up.
  EXPECT_EQ(canvas.At(300, 49), picture.RobotColor(0));
  EXPECT_EQ(canvas.At(99, 150), picture.RobotColor(1));
  EXPECT_NE(picture.RobotColor(0), picture.RobotColor(1));
  EXPECT_EQ(canvas.At(99, 49), kWhite);
  EXPECT_EQ(canvas.At(300, 150), kWhite);
}

TEST(TopDownPicture, TheGridIsAtRoundCoordinatesAndTheOriginIsMarked) {
  PictureOptions options = Small();
  options.grid = true;  // 400 pixels of 0.05 m: a line every 2 m, which is 40 pixels.
  const Canvas canvas = Make(options).Draw();
  EXPECT_NE(canvas.At(240, 77), kWhite) << "x = 2";
  EXPECT_NE(canvas.At(253, 60), kWhite) << "y = 2";
  EXPECT_EQ(canvas.At(250, 77), kWhite);
  const Color right = canvas.At(215, 100), up = canvas.At(200, 85);
  EXPECT_GT(right[0], right[1] + 100) << "x is red";
  EXPECT_GT(up[1], up[0] + 100) << "y is green";
}

TEST(TopDownPicture, AWorldFilePlacesTheFirstPixel) {
  EXPECT_EQ(Make(Small()).WorldFile(), "0.05\n0\n0\n-0.05\n-9.975\n4.975\n");
  EXPECT_EQ(WorldFilePath("maps/hall.png"), "maps/hall.pgw");
}

TEST(TopDownPicture, WallsAreDarkerThanFloors) {
  TopDownPicture picture = Make(Small());
  picture.Add(Post(0, 0, 0));
  picture.Add({{3, 0, 0, 0, 0}});
  const Canvas canvas = picture.Draw();
  const auto brightness = [](Color c) { return int{c[0]} + c[1] + c[2]; };
  EXPECT_LT(brightness(canvas.At(200, 100)), brightness(canvas.At(260, 100)) - 200);
  EXPECT_LT(brightness(canvas.At(260, 100)), brightness(kWhite));
}

TEST(TopDownPicture, HeightsOutsideTheCutAreLeftOut) {
  PictureOptions options = Small();
  options.min_z_m = 0.5;
  options.max_z_m = 2;
  TopDownPicture picture = Make(options);
  picture.Add({{3, 0, 0.2f, 0, 0}, {-3, 0, 2.5f, 0, 0}, {0, 0, 1, 0, 0}});
  const Canvas canvas = picture.Draw();
  EXPECT_EQ(canvas.At(260, 100), kWhite);
  EXPECT_EQ(canvas.At(140, 100), kWhite);
  EXPECT_NE(canvas.At(200, 100), kWhite);
}

TEST(TopDownPicture, OddPointsDoNoHarm) {
  TopDownPicture picture = Make(Small());
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  picture.Add({{kNan, 0, 0, 0, 0}, {0, 0, kNan, 0, 0}, {kInf, 0, 0, 0, 0}, {0, 0, kInf, 0, 0}});
  picture.Add(
      {{0, 0, 1, 0, 7}, {1e30f, 0, 0, 0, 0}, {-10, 5, 0, 0, 0}, {9.999f, -4.999f, 0, 0, 1}});
  picture.AddTrajectory(0, {{0, Pose(Eigen::Vector3d(1e9, 0, 0))}, {1, Pose()}});
  picture.AddTrajectory(1, {});
  picture.AddTrajectory(1, {{0, Pose(Eigen::Vector3d(NAN, 0, 0))}});
  const Canvas canvas = picture.Draw();
  EXPECT_NE(canvas.At(0, 0), kWhite);
  EXPECT_NE(canvas.At(399, 199), kWhite);
}

TEST(TopDownPicture, TrajectoryIsDrawnOverThePoints) {
  TopDownPicture picture = Make(Small());
  for (float x = -9; x < 9; x += 0.05f) picture.Add(Post(x, 1.0f, 0));
  const Color wall = picture.Draw().At(200, 80);
  picture.AddTrajectory(
      0, {{0, Pose(Eigen::Vector3d(0, -4, 0))}, {1, Pose(Eigen::Vector3d(0, 4, 0))}});
  EXPECT_NE(picture.Draw().At(200, 80), wall);
  EXPECT_NE(picture.Draw().At(200, 120), kWhite);
}

TEST(TopDownPicture, RefusesWhatCannotBeDrawn) {
  const auto code = [](const Box& extent, int side) {
    PictureOptions options;
    options.max_side_px = side;
    return TopDownPicture::Create(extent, {"a"}, options).status().code();
  };
  EXPECT_EQ(code(Box(), 400), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(code(Extent(0, 0, 0, 5), 400), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(code(Extent(0, 0, INFINITY, 5), 400), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(code(Extent(0, 0, 5, 5), 50), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(code(Extent(0, 0, 5, 5), 20000), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(code(Extent(0, 0, 5, 5), 400), absl::StatusCode::kOk);
}

TEST(PictureExtent, LeavesOutFarStragglersButNoTrajectory) {
  std::vector<MapPoint> points;
  for (int i = 0; i < 10000; ++i) {
    points.push_back(
        {static_cast<float>(i % 100) * 0.1f, static_cast<float>(i / 100) * 0.1f, 0, 0, 0});
  }
  points.push_back({500, 500, 50, 0, 0});
  points.push_back({NAN, INFINITY, 0, 0, 0});
  const Box box = PictureExtent(points, {{{0, Pose(Eigen::Vector3d(-30, 4, 0))}}});
  EXPECT_NEAR(box.min.x(), -30, 1.5);
  EXPECT_NEAR(box.max.x(), 10, 1.5);
  EXPECT_NEAR(box.max.y(), 10, 1.5);
  EXPECT_TRUE(PictureExtent({}, {}).empty());
}

TEST(Picture, FileIsAPngWithTheDrawnPixels) {
  const std::string path = ::testing::TempDir() + "isthmus_picture_test.png";
  PictureOptions options = Small();
  TopDownPicture picture = Make(options);
  picture.Add(Post(5.02f, 2.52f, 0));
  ASSERT_TRUE(picture.WritePng(path).ok());
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_file(&image, path.c_str()), 0) << image.message;
  image.format = PNG_FORMAT_RGB;
  std::vector<uint8_t> pixels(PNG_IMAGE_SIZE(image));
  ASSERT_NE(png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr), 0);
  EXPECT_EQ(image.width, 400u);
  EXPECT_EQ(image.height, 200u);
  const uint8_t* p = &pixels[3 * (49 * 400 + 300)];
  EXPECT_EQ((Color{p[0], p[1], p[2]}), picture.RobotColor(0));
  std::filesystem::remove(path);
  EXPECT_FALSE(picture.WritePng("/nowhere/at/all.png").ok());
}

}  // namespace
}  // namespace isthmus::evaluation
