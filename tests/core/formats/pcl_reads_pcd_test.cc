// Agreement with the library that defined the format.
#include <gtest/gtest.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>
#include <unistd.h>

#include <cstdio>

#include "core/codec/payload_builder.h"
#include "core/codec/payload_layout.h"
#include "core/formats/map_writer.h"
#include "core/formats/pcd.h"
#include "core/io/file_io.h"
#include "tests/core/codec/payloads.h"

namespace isthmus::formats {
namespace {

constexpr PcdEncoding kEncodings[] = {PcdEncoding::kAscii, PcdEncoding::kBinary,
                                      PcdEncoding::kBinaryCompressed};

class PclReadsPcd : public ::testing::TestWithParam<PcdEncoding> {
 protected:
  ~PclReadsPcd() override { std::remove(path_.c_str()); }
  const std::string path_ =
      ::testing::TempDir() + "isthmus_pcl_" + std::to_string(getpid()) + ".pcd";
};

TEST_P(PclReadsPcd, OurScans) {
  const std::vector<ScanPoint> points = codec::RoomScan(100);
  ASSERT_TRUE(WritePcd(path_, codec::MakePayload(points, true, true), GetParam()).ok());
  pcl::PointCloud<pcl::PointXYZI> cloud;
  ASSERT_EQ(pcl::io::loadPCDFile(path_, cloud), 0);
  ASSERT_EQ(cloud.size(), points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(cloud[i].x, points[i].x);
    EXPECT_EQ(cloud[i].y, points[i].y);
    EXPECT_EQ(cloud[i].z, points[i].z);
    EXPECT_EQ(cloud[i].intensity, points[i].intensity);
  }
}

TEST_P(PclReadsPcd, OurMaps) {
  std::vector<MapPoint> points;
  for (int i = 0; i < 5000; ++i) {
    points.push_back({0.1f * i, 7, -0.3f * i, 1.0f * (i % 9), static_cast<uint32_t>(i % 2),
                      static_cast<PointClass>(i % kPointClasses)});
  }
  const std::string header = PcdMapHeader(points.size(), GetParam(), {RobotId("alice")});
  const bool compressed = GetParam() == PcdEncoding::kBinaryCompressed;
  const std::string body = compressed ? *PcdMapCompressed(points) : PcdMapChunk(points, GetParam());
  ASSERT_TRUE(io::WriteFile(path_, header + body).ok());
  pcl::PCLPointCloud2 blob;
  ASSERT_EQ(pcl::io::loadPCDFile(path_, blob), 0);
  ASSERT_EQ(blob.fields.size(), 6u);
  EXPECT_EQ(blob.fields[4].name, "robot");
  EXPECT_EQ(blob.fields[5].name, "label");
  ASSERT_EQ(blob.width, points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(std::memcmp(&blob.data[i * blob.point_step], &points[i], kMapRecordBytes), 0) << i;
  }
}

TEST_P(PclReadsPcd, AndWeReadItsOwn) {
  pcl::PointCloud<pcl::PointXYZI> cloud;
  for (int i = 0; i < 700; ++i) {
    pcl::PointXYZI p;
    p.x = 0.1f * static_cast<float>(i);
    p.y = 3;
    p.z = -static_cast<float>(i);
    p.intensity = static_cast<float>(i % 5);
    cloud.push_back(p);
  }
  pcl::PCDWriter writer;
  constexpr int kDigits = 9;
  if (GetParam() == PcdEncoding::kAscii) writer.writeASCII(path_, cloud, kDigits);
  if (GetParam() == PcdEncoding::kBinary) writer.writeBinary(path_, cloud);
  if (GetParam() == PcdEncoding::kBinaryCompressed) writer.writeBinaryCompressed(path_, cloud);
  const auto file = ReadPcd(path_);
  ASSERT_TRUE(file.ok()) << file.status();
  ASSERT_EQ(codec::PointCount(file->payload), cloud.size());
  const auto x = codec::ReadColumn(file->payload, *codec::FindField(file->payload, {"x"}));
  const auto intensity =
      codec::ReadColumn(file->payload, *codec::FindField(file->payload, {"intensity"}));
  for (size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_EQ(static_cast<float>(x[i]), cloud[i].x);
    EXPECT_EQ(static_cast<float>(intensity[i]), cloud[i].intensity);
  }
}

INSTANTIATE_TEST_SUITE_P(Encodings, PclReadsPcd, ::testing::ValuesIn(kEncodings),
                         [](const auto& param) {
                           return std::string(param.param == PcdEncoding::kAscii    ? "Ascii"
                                              : param.param == PcdEncoding::kBinary ? "Binary"
                                                                                    : "Compressed");
                         });

}  // namespace
}  // namespace isthmus::formats
