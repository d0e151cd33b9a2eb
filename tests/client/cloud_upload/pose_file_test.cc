// Files of poses, whole and damaged.
#include "client/cloud_upload/pose_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/io/file_io.h"

namespace isthmus::cloud_upload {
namespace {

using testing::HasSubstr;

constexpr char kTurned[] = "0 -1 0 1 1 0 0 2 0 0 1 3";  // 90 degrees about z, at 1 2 3.

std::string WhyNot(const std::string& text) {
  const auto file = ParsePoses(text);
  EXPECT_TRUE(absl::IsInvalidArgument(file.status())) << text;
  return std::string(file.status().message());
}

TEST(PoseFileTest, TwoPosesOfOneInstantMustBeOne) {
  EXPECT_TRUE(ParsePoses("1 0 0 0 0 0 0 1\n1 0.001 0 0 0 0 0 1\n").ok());
  EXPECT_THAT(WhyNot("2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n2 5 0 0 0 0 0 1\n"),
              HasSubstr("two poses of 2.000000 s are 5.000 m apart"));
}

TEST(PoseFileTest, FarPosesAreMovedNearTheOriginAsAWhole) {
  const auto file = ParsePoses("1 691234.5 5334100 520 0 0 0 1\n2 691236.5 5334100 520 0 0 0 1\n");
  ASSERT_TRUE(file.ok());
  EXPECT_EQ(file->moved_by, Eigen::Vector3d(-691'000, -5'334'000, 0));
  EXPECT_NEAR(file->poses[0].pose.translation().x(), 234.5, 1e-6);
  EXPECT_NEAR(file->poses[1].pose.translation().x(), 236.5, 1e-6);
  EXPECT_TRUE(ParsePoses("1 1900 0 0 0 0 0 1\n")->moved_by.isZero());
}

TEST(PoseFileTest, TheNumberOfColumnsTellsTheFormat) {
  const auto tum = ParsePoses("# a comment\n12.5 1 2 3 0 0 0 1\n");
  ASSERT_TRUE(tum.ok()) << tum.status();
  EXPECT_EQ(tum->format, PoseFormat::kTum);
  EXPECT_TRUE(tum->has_stamps);
  EXPECT_EQ(tum->poses[0].stamp_ns, 12'500'000'000);

  const auto kitti = ParsePoses(std::string("1 0 0 0 0 1 0 0 0 0 1 0\n") + kTurned + "\r\n\n");
  ASSERT_TRUE(kitti.ok()) << kitti.status();
  EXPECT_EQ(kitti->format, PoseFormat::kKitti);
  EXPECT_FALSE(kitti->has_stamps);
  ASSERT_EQ(kitti->poses.size(), 2u);
  EXPECT_TRUE(kitti->poses[1].pose.translation().isApprox(Eigen::Vector3d(1, 2, 3)));
  EXPECT_NEAR(kitti->poses[1].pose.Yaw(), std::acos(0.0), 1e-9);

  const auto g2o = ParsePoses(
      "VERTEX_SE3:QUAT 7 7 0 0 0 0 0 1\nVERTEX_SE3:QUAT 2 2 0 0 0 0 0 1\nEDGE_SE3:QUAT 2 7 5 0 0 0 "
      "0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n");
  ASSERT_TRUE(g2o.ok()) << g2o.status();
  EXPECT_EQ(g2o->format, PoseFormat::kG2o);
  ASSERT_EQ(g2o->poses.size(), 2u);
  EXPECT_DOUBLE_EQ(g2o->poses[0].pose.translation().x(), 2) << "in order of ids";
}

TEST(PoseFileTest, OfAGraphOnlyVerticesAreRead) {
  const auto g2o = ParsePoses(
      "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\nVERTEX_PLANE 4 0 0 1 0\n"
      "EDGE_SE3_PLANE 0 4 0 0 1 0 1 0 0 1 0 1\nEDGE_SE3:QUAT 0 9 cut\nFIX 0\n");
  ASSERT_TRUE(g2o.ok()) << g2o.status();
  EXPECT_EQ(g2o->poses.size(), 2u);
  EXPECT_THAT(WhyNot("EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n"),
              HasSubstr("isthmus optimize"));
}

TEST(PoseFileTest, WhatIsWrongIsNamedByItsLine) {
  EXPECT_THAT(WhyNot("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0\n"), HasSubstr("line 2: 7 values"));
  EXPECT_THAT(WhyNot("1 0 0 0 0 0 0 0\n"), HasSubstr("line 1: the quaternion is zero"));
  const std::string good = std::string(kTurned) + "\n";
  EXPECT_THAT(WhyNot(good + "\n# x\n1 2 3\n"), HasSubstr("line 4: 3 values instead of 12"));
  EXPECT_THAT(WhyNot(good + "0 -1 0 1 1 0 0 2 0 0 1 nan\n"), HasSubstr("line 2: 'nan'"));
  EXPECT_THAT(WhyNot(good + "0 -1 0 1 1 0 0 two 0 0 1 3\n"), HasSubstr("line 2: 'two'"));
  EXPECT_THAT(WhyNot(good + "2 0 0 1 0 1 0 2 0 0 1 3\n"), HasSubstr("line 2"));
  EXPECT_THAT(WhyNot(good + "1 0 0 1 0 1 0 2 0 0 -1 3\n"), HasSubstr("no rotation")) << "mirror";
  EXPECT_THAT(WhyNot("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 0 0\n"),
              HasSubstr("line 2"));
  EXPECT_THAT(WhyNot(""), HasSubstr("holds no poses"));
  EXPECT_THAT(WhyNot("# only words\n"), HasSubstr("holds no poses"));
}

TEST(PoseFileTest, TimesBesideKittisPosesStampThem) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "isthmus_pose_file_test";
  std::filesystem::create_directories(folder);
  const std::string poses = folder / "poses.txt", times = folder / "times.txt";
  ASSERT_TRUE(io::WriteFile(poses, std::string(kTurned) + "\n" + kTurned + "\n").ok());
  ASSERT_TRUE(io::WriteFile(times, "0.5\n1.5\n").ok());
  const auto stamped = ReadPoses(poses);
  ASSERT_TRUE(stamped.ok()) << stamped.status();
  EXPECT_TRUE(stamped->has_stamps);
  EXPECT_EQ(stamped->poses[1].stamp_ns, 1'500'000'000);
  ASSERT_TRUE(io::WriteFile(times, "0.5\n").ok());
  EXPECT_FALSE(ReadPoses(poses)->has_stamps) << "those of something else";
  ASSERT_TRUE(io::WriteFile(times, "0.5\nnever\n").ok());
  EXPECT_THAT(std::string(ReadPoses(poses).status().message()), HasSubstr("times.txt: line 2"));
  ASSERT_TRUE(io::WriteFile(poses, "1 2 3\n").ok());
  EXPECT_THAT(std::string(ReadPoses(poses).status().message()), HasSubstr("poses.txt: line 1"));
  EXPECT_TRUE(absl::IsNotFound(ReadPoses(folder / "none.txt").status()));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace isthmus::cloud_upload
