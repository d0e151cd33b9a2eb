#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/codec/scan_decoder.h"
#include "core/formats/kitti_bin.h"
#include "core/formats/tum.h"
#include "core/io/file_io.h"

namespace isthmus::formats {
namespace {

using ::testing::HasSubstr;

TEST(ReadFile, SaysWhichFileAndWhy) {
  const std::string missing = ::testing::TempDir() + "isthmus_no_such_file";
  const auto status = io::ReadFile(missing).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr(missing));
  EXPECT_EQ(io::ReadFile(::testing::TempDir()).status().code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(io::WriteFile(missing + "/x", "x").code(), absl::StatusCode::kNotFound);
}

TEST(WriteFile, SaysWhenTheDiskIsFull) {
  EXPECT_EQ(io::WriteFile("/dev/full", "x").code(), absl::StatusCode::kResourceExhausted);
}

TEST(WriteFile, RoundTrips) {
  const std::string path = ::testing::TempDir() + "isthmus_write_file";
  const std::string bytes("a\0b\r\n", 5);
  ASSERT_TRUE(io::WriteFile(path, bytes + bytes).ok());
  ASSERT_TRUE(io::WriteFile(path, bytes).ok());  // Shorter: the old end is gone.
  EXPECT_EQ(*io::ReadFile(path), bytes);
  std::filesystem::remove(path);
}

TEST(KittiBin, IsFourFloatsPerPoint) {
  const float values[] = {1, 2, 3, 0.5f, 4, 5, 6, 0.25f};
  const auto payload =
      ParseKittiBin(std::string(reinterpret_cast<const char*>(values), sizeof(values)));
  ASSERT_TRUE(payload.ok());
  const auto scan = codec::DecodeScan(*payload, 1, 2);
  ASSERT_TRUE(scan.ok()) << scan.status();
  ASSERT_EQ(scan->points.size(), 2u);
  EXPECT_EQ(scan->points[1].y, 5);
  EXPECT_EQ(scan->points[1].intensity, 0.25f);
  EXPECT_EQ(ParseKittiBin(std::string(33, 'x')).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(Tum, KeepsNanosecondsAndPoses) {
  Trajectory trajectory;
  for (int i = 0; i < 20; ++i) {
    StampedPose stamped;
    stamped.stamp_ns = 1'700'000'000'000'000'001 + i * 100'000'007;
    stamped.pose = Pose::FromXyzRpy(0.1 * i, -i, 3, 0.01 * i, 0.02, 0.3 * i);
    trajectory.push_back(stamped);
  }
  trajectory.push_back({5, Pose()});
  trajectory.push_back({-1'500'000'000, Pose()});
  const auto back = ParseTum(FormatTum(trajectory));
  ASSERT_TRUE(back.ok()) << back.status();
  ASSERT_EQ(back->size(), trajectory.size());
  for (size_t i = 0; i < back->size(); ++i) {
    EXPECT_EQ((*back)[i].stamp_ns, trajectory[i].stamp_ns);
    const Pose error = (*back)[i].pose.Inverse() * trajectory[i].pose;
    EXPECT_LT(Log(error).norm(), 1e-7);
  }
}

TEST(Tum, ReadsWhatOthersWrite) {
  const auto read = ParseTum(
      "# a comment\r\n\r\n1305031102.1753 1.0 2e0 -3 0 0 0 2\r\n"
      "1.5e1\t0 0 0 0 0 0.6 0.8\n7,0,0,0,0,0,0,-1");
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->size(), 3u);
  EXPECT_EQ((*read)[0].stamp_ns, 1'305'031'102'175'300'000);
  EXPECT_EQ((*read)[0].pose.translation(), Eigen::Vector3d(1, 2, -3));
  EXPECT_DOUBLE_EQ((*read)[0].pose.rotation().w(), 1);
  EXPECT_EQ((*read)[1].stamp_ns, 15'000'000'000);
  EXPECT_EQ((*read)[2].stamp_ns, 7'000'000'000);
}

TEST(Tum, NamesTheLineThatIsWrong) {
  for (const char* bad : {"1 2 3", "1 0 0 0 0 0 0 1 9", "x 0 0 0 0 0 0 1", "1 0 nan 0 0 0 0 1",
                          "1 0 0 0 0 0 0 0", "1e99 0 0 0 0 0 0 1", "9000000000.5 0 0 0 0 0 0 1",
                          "-9e9 0 0 0 0 0 0 1", "1 0 0 0 0 0 0 1z"}) {
    const auto status = ParseTum(std::string("#\n") + bad).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << bad;
    EXPECT_THAT(std::string(status.message()), HasSubstr("line 2"));
  }
}

}  // namespace
}  // namespace isthmus::formats
