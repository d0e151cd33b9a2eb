#include "server/query/export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "core/codec/payload_layout.h"
#include "core/formats/pcd.h"

namespace isthmus::query {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

// Points in a list; a region's robot is the only part it heeds.
class ListMap : public ComposedMap {
 public:
  explicit ListMap(std::vector<MapPoint> points, absl::Status status = absl::OkStatus())
      : points_(std::move(points)), status_(std::move(status)) {}

  int64_t revision() const override { return 1; }
  const std::vector<RobotId>& robots() const override { return robots_; }
  uint32_t component_count() const override { return 1; }
  uint64_t point_count(uint32_t) const override { return points_.size(); }
  Box bounds(uint32_t) const override { return {}; }
  absl::Status Read(const Region& region, size_t chunk, const Emit& emit) const override {
    std::vector<MapPoint> buffer;
    for (const MapPoint& p : points_) {
      if (region.robot >= 0 && p.robot != static_cast<uint32_t>(region.robot)) continue;
      buffer.push_back(p);
      if (buffer.size() < chunk) continue;
      if (!emit(buffer)) return absl::OkStatus();
      buffer.clear();
    }
    if (!buffer.empty()) emit(buffer);
    return status_;
  }

 private:
  const std::vector<MapPoint> points_;
  const absl::Status status_;  // Returned by Read at its end.
  const std::vector<RobotId> robots_{RobotId("alice"), RobotId("bob")};
};

std::vector<MapPoint> RandomPoints(int count) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> metres(-500, 500);
  std::vector<MapPoint> points;
  for (int i = 0; i < count; ++i) {
    points.push_back({metres(rng), metres(rng), metres(rng), float(rng() % 256), uint32_t(i % 2)});
  }
  return points;
}

std::string Export(const ComposedMap& map, CloudFormat format, const Region& region = {}) {
  std::string file;
  const absl::Status status = ExportCloud(map, region, format, [&](const std::string& bytes) {
    file += bytes;
    return true;
  });
  EXPECT_TRUE(status.ok()) << status;
  return file;
}

void ExpectPoints(const PointPayload& payload, const std::vector<MapPoint>& expected) {
  ASSERT_EQ(codec::PointCount(payload), expected.size());
  ASSERT_EQ(payload.fields.size(), 6u);
  EXPECT_EQ(payload.fields[4].name, "robot");
  EXPECT_EQ(payload.fields[4].type, ScalarType::kUint32);
  const auto column = [&](const char* name) {
    const PointField* field = codec::FindField(payload, {name});
    EXPECT_NE(field, nullptr) << name;
    return field ? codec::ReadColumn(payload, *field) : std::vector<double>(expected.size());
  };
  const auto x = column("x"), y = column("y"), z = column("z");
  const auto intensity = column("intensity"), robot = column("robot");
  for (size_t i = 0; i < expected.size(); ++i) {
    ASSERT_EQ(static_cast<float>(x[i]), expected[i].x) << i;
    ASSERT_EQ(static_cast<float>(y[i]), expected[i].y) << i;
    ASSERT_EQ(static_cast<float>(z[i]), expected[i].z) << i;
    ASSERT_EQ(static_cast<float>(intensity[i]), expected[i].intensity) << i;
    ASSERT_EQ(static_cast<uint32_t>(robot[i]), expected[i].robot) << i;
  }
}

class PcdExport : public ::testing::TestWithParam<CloudFormat> {};

INSTANTIATE_TEST_SUITE_P(Encodings, PcdExport,
                         ::testing::Values(CloudFormat::kPcdAscii, CloudFormat::kPcdBinary,
                                           CloudFormat::kPcdBinaryCompressed));

TEST_P(PcdExport, EveryPointComesBack) {
  const auto points = RandomPoints(50001);  // More than one piece, the last one not full.
  const std::string file = Export(ListMap(points), GetParam());
  const auto pcd = formats::ParsePcd(file);
  ASSERT_TRUE(pcd.ok()) << pcd.status();
  ExpectPoints(pcd->payload, points);
  const std::string header = file.substr(0, 500);
  EXPECT_THAT(header, HasSubstr("POINTS 50001\n"));
  EXPECT_THAT(header, HasSubstr("robot 1 bob"));
}

TEST_P(PcdExport, CountIsThatOfTheRegion) {
  auto points = RandomPoints(1001);
  Region region;
  region.robot = 1;
  const auto pcd = formats::ParsePcd(Export(ListMap(points), GetParam(), region));
  ASSERT_TRUE(pcd.ok()) << pcd.status();
  points.erase(
      std::remove_if(points.begin(), points.end(), [](const MapPoint& p) { return p.robot != 1; }),
      points.end());
  ExpectPoints(pcd->payload, points);
}

TEST_P(PcdExport, NothingIsAFileOfNoPoints) {
  const auto pcd = formats::ParsePcd(Export(ListMap({}), GetParam()));
  ASSERT_TRUE(pcd.ok()) << pcd.status();
  EXPECT_EQ(codec::PointCount(pcd->payload), 0u);
}

TEST(PlyExport, HeaderAndRecords) {
  const auto points = RandomPoints(30000);
  const std::string file = Export(ListMap(points), CloudFormat::kPly);
  EXPECT_THAT(file, StartsWith("ply\nformat binary_little_endian 1.0\n"));
  const std::string end = "end_header\n";
  const size_t header_size = file.find(end) + end.size();
  EXPECT_THAT(file.substr(0, header_size), HasSubstr("element vertex 30000\n"));
  constexpr size_t kRecord = 4 * sizeof(float) + 2 * sizeof(uint32_t);
  ASSERT_EQ(file.size(), header_size + points.size() * kRecord);
  for (size_t i = 0; i < points.size(); ++i) {
    const char* record = file.data() + header_size + i * kRecord;
    float values[4];
    uint32_t robot = 0;
    std::memcpy(values, record, sizeof(values));
    std::memcpy(&robot, record + sizeof(values), sizeof(robot));
    ASSERT_EQ(values[0], points[i].x) << i;
    ASSERT_EQ(values[2], points[i].z) << i;
    ASSERT_EQ(values[3], points[i].intensity) << i;
    ASSERT_EQ(robot, points[i].robot) << i;
  }
}

TEST(Export, SinkThatHadEnoughIsAskedNoMore) {
  const ListMap map(RandomPoints(100000));
  for (const CloudFormat format : {CloudFormat::kPcdAscii, CloudFormat::kPcdBinary,
                                   CloudFormat::kPcdBinaryCompressed, CloudFormat::kPly}) {
    for (int pieces = 1; pieces <= 3; ++pieces) {
      int calls = 0;
      const absl::Status status =
          ExportCloud(map, {}, format, [&](const std::string&) { return ++calls < pieces; });
      EXPECT_EQ(status.code(), absl::StatusCode::kCancelled) << status;
      EXPECT_EQ(calls, pieces);
    }
  }
}

TEST(Export, PointsThatCannotBeReadFailIt) {
  const ListMap map(RandomPoints(100000), absl::DataLossError("the spill file is gone"));
  for (const CloudFormat format : {CloudFormat::kPcdAscii, CloudFormat::kPcdBinary,
                                   CloudFormat::kPcdBinaryCompressed, CloudFormat::kPly}) {
    const absl::Status status =
        ExportCloud(map, {}, format, [](const std::string&) { return true; });
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << status;
  }
}

TEST(Export, PiecesAreSmall) {
  const ListMap map(RandomPoints(100000));
  for (const CloudFormat format : {CloudFormat::kPcdAscii, CloudFormat::kPcdBinary,
                                   CloudFormat::kPcdBinaryCompressed, CloudFormat::kPly}) {
    const absl::Status status = ExportCloud(map, {}, format, [&](const std::string& bytes) {
      EXPECT_LE(bytes.size(), size_t{2} << 20);  // Fits a gRPC message with room to spare.
      return true;
    });
    EXPECT_TRUE(status.ok()) << status;
  }
}

}  // namespace
}  // namespace isthmus::query
