#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

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

// A turn of 4 rings, 2 m below to 1 m above the sensor; a column holds `value_of(point)`.
std::string Floats(const std::vector<std::function<float(int)>>& columns, bool by_column) {
  constexpr int kPoints = 202;  // Times 5 or 6 not whole points of 4 columns.
  std::string bytes;
  const auto add = [&](float value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  if (by_column) {
    for (const auto& column : columns) {
      for (int i = 0; i < kPoints; ++i) add(column(i));
    }
    return bytes;
  }
  for (int i = 0; i < kPoints; ++i) {
    for (const auto& column : columns) add(column(i));
  }
  return bytes;
}

const std::vector<std::function<float(int)>> kColumns = {
    [](int i) { return 9 * std::cos(0.03F * static_cast<float>(i)); },
    [](int i) { return 9 * std::sin(0.03F * static_cast<float>(i)); },
    [](int i) { return static_cast<float>(i % 4) - 2; },
    [](int i) { return static_cast<float>(i % 100) / 100; },
    [](int i) { return static_cast<float>(i % 4); },
    [](int i) { return -0.1F + 0.0005F * static_cast<float>(i); }};

TEST(KittiBin, OtherColumnsAreToldByTheirValues) {
  for (const bool by_column : {false, true}) {
    for (const size_t columns : {4, 5, 6}) {
      if (by_column && columns > 4) continue;
      const auto payload =
          ParseKittiBin(Floats({kColumns.begin(), kColumns.begin() + columns}, by_column));
      ASSERT_TRUE(payload.ok()) << columns << payload.status();
      ASSERT_EQ(payload->width, 202u) << columns << by_column;
      const auto scan = codec::DecodeScan(*payload, 1, 2);
      ASSERT_TRUE(scan.ok()) << scan.status();
      EXPECT_EQ(scan->has_ring, columns > 4);
      EXPECT_EQ(scan->has_time, columns > 5);
      for (int i = 0; i < 202; ++i) {
        const ScanPoint& p = scan->points[i];
        ASSERT_EQ(p.x, kColumns[0](i)) << columns;
        ASSERT_EQ(p.z, kColumns[2](i));
        ASSERT_EQ(p.intensity, kColumns[3](i));
        ASSERT_EQ(p.ring, columns > 4 ? i % 4 : 0);
      }
    }
  }
}

TEST(KittiBin, WhatFitsNoLayoutIsRefused) {
  const auto& c = kColumns;
  for (const auto& columns : {std::vector{c[0], c[1], c[2]},
                              {c[0], c[1], c[2], c[3], c[5]},
                              {c[0], c[1], c[2], c[0], c[1], c[2], c[3]}}) {
    EXPECT_EQ(ParseKittiBin(Floats(columns, false)).status().code(),
              absl::StatusCode::kInvalidArgument)
        << columns.size();
  }
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
      "\xEF\xBB\xBF# a comment\r\n\r\n1305031102.1753 1.0 2e0 -3 0 0 0 2\r\n"
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
