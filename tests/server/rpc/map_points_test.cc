// QueryRegion and ExportMap over a socket: chunks, limits, checksums.
#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/io/crc32c.h"
#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

class QueryRegionTest : public RpcTest {
 protected:
  QueryRegionTest() {
    pipeline_.map->robots_ = {RobotId("alice"), RobotId("bob")};
    pipeline_.map->components_ = 1;
    pipeline_.info.robots = {RobotId("alice"), RobotId("bob"), RobotId("carol")};
    for (uint32_t i = 0; i < 10; ++i) {
      pipeline_.map->points_.push_back(
          {static_cast<float>(i), 0, 0, 0.5F, i % 2, static_cast<PointClass>(i)});
    }
  }

  grpc::Status Query(const v1::QueryRegionRequest& request) {
    responses_.clear();
    points_.clear();
    const auto context = NewContext();
    auto reader = stubs_->map->QueryRegion(context.get(), request);
    v1::QueryRegionResponse response;
    while (reader->Read(&response)) {
      const std::string& data = response.cloud().data();
      // With or without labels, which come last.
      const size_t stride = response.cloud().stride();
      EXPECT_EQ(data.size(), response.cloud().width() * stride);
      for (size_t at = 0; at < data.size(); at += stride) {
        void* const point = &points_.emplace_back();
        std::memcpy(point, data.data() + at, stride);
      }
      responses_.push_back(response);
    }
    return reader->Finish();
  }

  std::vector<v1::QueryRegionResponse> responses_;
  std::vector<MapPoint> points_;
};

v1::QueryRegionRequest BoxFrom(double min_x, double max_x) {
  v1::QueryRegionRequest request;
  v1::Box& box = *request.mutable_box();
  box.mutable_min()->set_x(min_x);
  box.mutable_min()->set_y(-1);
  box.mutable_min()->set_z(-1);
  box.mutable_max()->set_x(max_x);
  box.mutable_max()->set_y(1);
  box.mutable_max()->set_z(1);
  return request;
}

TEST_F(QueryRegionTest, MapThatIsNotComposedYetIsUnavailable) {
  pipeline_.map->ready_ = absl::UnavailableError("composed after the start, 34 %");
  EXPECT_GRPC_ERROR(Query({}), UNAVAILABLE, "34 %");
  EXPECT_TRUE(responses_.empty());
}

TEST_F(QueryRegionTest, PointsThatCannotBeReadAreAnError) {
  pipeline_.map->read_ = absl::DataLossError("the spill file is gone");
  EXPECT_GRPC_ERROR(Query({}), DATA_LOSS, "spill file");
}

TEST_F(QueryRegionTest, PointsComeWithTheirClassAndByIt) {
  v1::QueryRegionRequest request;
  for (const auto wanted : {v1::QueryRegionRequest::INTENSITY, v1::QueryRegionRequest::ROBOT,
                            v1::QueryRegionRequest::LABEL}) {
    request.add_attributes(wanted);
  }
  EXPECT_GRPC_OK(Query(request));
  ASSERT_EQ(points_.size(), 10u);
  EXPECT_EQ(responses_.back().cloud().fields(5).name(), "label");
  for (uint32_t i = 0; i < 10; ++i) EXPECT_EQ(points_[i].label, static_cast<PointClass>(i));
  request.add_classes(v1::POINT_CLASS_WALL);
  request.add_classes(v1::POINT_CLASS_UNKNOWN);
  EXPECT_GRPC_OK(Query(request));
  ASSERT_EQ(points_.size(), 2u);
  EXPECT_EQ(points_[0].label, PointClass::kUnknown);
  EXPECT_EQ(points_[1].label, PointClass::kWall);
  request.add_classes(static_cast<v1::PointClass>(77));
  EXPECT_GRPC_ERROR(Query(request), INVALID_ARGUMENT, "class 77");
}

TEST_F(QueryRegionTest, WithoutARegionEverythingComes) {
  EXPECT_GRPC_OK(Query({}));
  EXPECT_EQ(points_.size(), 10u);
  EXPECT_EQ(points_[3].x, 3);
  EXPECT_EQ(points_[3].robot, 1u);
  EXPECT_EQ(points_[3].intensity, 0.5F);
  EXPECT_EQ(responses_[0].revision(), 7);
  EXPECT_THAT(responses_[0].robots(), testing::ElementsAre("alice", "bob"));
  const v1::PointCloud& cloud = responses_[0].cloud();
  EXPECT_EQ(cloud.encoding(), v1::PointCloud::RAW);
  EXPECT_EQ(cloud.stride(), 20u);
  ASSERT_EQ(cloud.fields_size(), 5);
  EXPECT_EQ(cloud.fields(4).name(), "robot");
  EXPECT_EQ(cloud.fields(4).offset(), 16u);
  EXPECT_EQ(cloud.fields(4).type(), v1::PointField::UINT32);
}

TEST_F(QueryRegionTest, BoxSphereAndRobot) {
  EXPECT_GRPC_OK(Query(BoxFrom(2, 5)));
  EXPECT_EQ(points_.size(), 4u);
  EXPECT_GRPC_OK(Query(BoxFrom(2, 2)));
  EXPECT_EQ(points_.size(), 1u);
  v1::QueryRegionRequest request;
  request.mutable_sphere()->mutable_center()->set_x(9);
  request.mutable_sphere()->set_radius_m(1.5);
  EXPECT_GRPC_OK(Query(request));
  EXPECT_EQ(points_.size(), 2u);
  request.set_robot("bob");
  EXPECT_GRPC_OK(Query(request));
  ASSERT_EQ(points_.size(), 1u);
  EXPECT_EQ(points_[0].x, 9);
}

TEST_F(QueryRegionTest, WhereNothingIsTheAnswerIsEmptyButNamesItsRevision) {
  EXPECT_GRPC_OK(Query(BoxFrom(100, 200)));
  ASSERT_EQ(responses_.size(), 1u);
  EXPECT_EQ(responses_[0].revision(), 7);
  EXPECT_EQ(responses_[0].robots_size(), 2);
  EXPECT_EQ(responses_[0].cloud().width(), 0u);
  // A robot that has no submap yet has no points either.
  ASSERT_TRUE(pipeline_.sessions().Create({.robot = RobotId("carol")}).ok());
  v1::QueryRegionRequest request;
  request.set_robot("carol");
  EXPECT_GRPC_OK(Query(request));
  EXPECT_TRUE(points_.empty());
}

TEST_F(QueryRegionTest, RobotOfAnotherMapIsRefusedByTheNameOfItsMap) {
  const auto session = pipeline_.sessions().Create({.robot = RobotId("bob")});
  ASSERT_TRUE(session.ok());
  pipeline_.map->components_ = 2;
  pipeline_.map->places_[session->record.id] = 1;
  v1::QueryRegionRequest request;
  request.set_robot("bob");
  EXPECT_GRPC_ERROR(Query(request), FAILED_PRECONDITION, session->record.id.value());
  request.set_component(1);
  EXPECT_GRPC_OK(Query(request));
}

TEST_F(QueryRegionTest, AnEmptyMapHasAnEmptyComponentZero) {
  pipeline_.map->components_ = 0;
  pipeline_.map->points_.clear();
  EXPECT_GRPC_OK(Query({}));
  EXPECT_EQ(responses_.size(), 1u);
}

TEST_F(QueryRegionTest, LargeAnswersComeInMessagesOfAboutOneMegabyte) {
  pipeline_.map->points_.assign(200'000, MapPoint{1, 2, 3, 4, 0});
  EXPECT_GRPC_OK(Query({}));
  EXPECT_EQ(points_.size(), 200'000u);
  EXPECT_GE(responses_.size(), 4u);
  for (const auto& response : responses_) EXPECT_LE(response.ByteSizeLong(), (1u << 20) + 1000);
  for (size_t i = 1; i < responses_.size(); ++i) EXPECT_EQ(responses_[i].robots_size(), 0);
}

// Has ten points, half as many with each doubling of the resolution; counts how often it is read.
class ThinningMap final : public FakeMap {
 public:
  ThinningMap() { components_ = 1; }
  double voxel_m() const override { return 0.1; }
  Box bounds(uint32_t) const override {
    Box box;
    box.Extend({0, 0, 0});
    box.Extend({9, 9, 9});
    return box;
  }
  absl::Status Read(const Region& region, size_t, const Emit& emit) const override {
    ++reads_;
    emit(std::vector<MapPoint>(CountAt(region.resolution_m)));
    return absl::OkStatus();
  }
  PointBounds BoundsOf(const Region& region) const override {
    const uint64_t count = CountAt(region.resolution_m);
    return {count - std::min(count, unknown_), count + unknown_};
  }

  uint64_t unknown_ = 0;  // The bounds are so far from the count.
  mutable std::atomic<int> reads_ = 0;

 private:
  static uint64_t CountAt(double resolution_m) {
    return std::max<uint64_t>(1, static_cast<uint64_t>(10 / std::max(1., resolution_m * 10)));
  }
};

// The finest resolution that fits is found without counting where the map knows, and counting is
// for those resolutions alone of which it does not.
TEST_F(QueryRegionTest, ABudgetIsCountedOnceAtMostWhereTheMapKnows) {
  const auto map = std::make_shared<ThinningMap>();
  pipeline_.map = map;
  v1::QueryRegionRequest request;
  request.set_max_points(2);
  for (const auto& [unknown, reads] : {std::pair(0, 1), std::pair(1, 2), std::pair(100, 5)}) {
    map->unknown_ = unknown;
    map->reads_ = 0;
    ASSERT_GRPC_OK(Query(request));
    EXPECT_EQ(responses_.back().resolution_m(), 0.4) << unknown;
    EXPECT_EQ(points_.size(), 2u) << unknown;
    EXPECT_EQ(map->reads_, reads) << unknown;
  }
}

TEST_F(QueryRegionTest, RegionsThatMakeNoSense) {
  EXPECT_GRPC_ERROR(Query(BoxFrom(5, 2)), INVALID_ARGUMENT, "exceeds box.max");
  EXPECT_GRPC_ERROR(Query(BoxFrom(kNaN, 2)), INVALID_ARGUMENT, "box.min");
  EXPECT_GRPC_ERROR(Query(BoxFrom(0, std::numeric_limits<double>::infinity())), INVALID_ARGUMENT,
                    "box.max");
  v1::QueryRegionRequest request;
  for (const double radius : {0.0, -1.0, 1e30, kNaN}) {
    request.mutable_sphere()->set_radius_m(radius);
    EXPECT_GRPC_ERROR(Query(request), INVALID_ARGUMENT, "give more than 0 and at most 1e+08 m");
  }
  request.mutable_sphere()->set_radius_m(1);
  request.mutable_sphere()->mutable_center()->set_y(kNaN);
  EXPECT_GRPC_ERROR(Query(request), INVALID_ARGUMENT, "sphere.center");
  request.Clear();
  for (const double resolution : {-0.1, 1e9, kNaN}) {
    request.set_resolution_m(resolution);
    EXPECT_GRPC_ERROR(Query(request), INVALID_ARGUMENT, "give 0 to 1e+08 m");
  }
  request.Clear();
  request.set_robot("dave");
  EXPECT_GRPC_ERROR(Query(request), NOT_FOUND, "dave");
  request.Clear();
  request.set_component(1);
  EXPECT_GRPC_ERROR(Query(request), NOT_FOUND, "no map 1");
  EXPECT_TRUE(responses_.empty());
}

class ExportMapTest : public RpcTest {
 protected:
  grpc::Status Export(const v1::ExportMapRequest& request) {
    responses_.clear();
    file_.clear();
    const auto context = NewContext();
    auto reader = stubs_->map->ExportMap(context.get(), request);
    v1::ExportMapResponse response;
    while (reader->Read(&response)) {
      file_ += response.data();
      responses_.push_back(response);
    }
    return reader->Finish();
  }

  std::vector<v1::ExportMapResponse> responses_;
  std::string file_;
};

v1::ExportMapRequest Ply() {
  v1::ExportMapRequest request;
  request.set_format(v1::ExportMapRequest::PLY);
  return request;
}

TEST_F(ExportMapTest, AFileComesInChunksAndIsSummedUpInTheLast) {
  std::string large(3'000'000, '\0');
  for (size_t i = 0; i < large.size(); ++i) large[i] = static_cast<char>(i * 31 >> 3);
  pipeline_.file = {"header\n", large, "tail"};
  EXPECT_GRPC_OK(Export(Ply()));
  EXPECT_EQ(file_, "header\n" + large + "tail");
  for (size_t i = 0; i < responses_.size(); ++i) {
    EXPECT_LE(responses_[i].data().size(), 1u << 20);
    EXPECT_EQ(responses_[i].revision(), 7);
    EXPECT_EQ(responses_[i].last(), i + 1 == responses_.size());
  }
  EXPECT_EQ(responses_.back().size(), file_.size());
  EXPECT_EQ(responses_.back().crc32c(), io::Crc32c(file_.data(), file_.size()));
}

TEST_F(ExportMapTest, WhatWasAskedReachesThePipeline) {
  v1::ExportMapRequest request;
  request.set_format(v1::ExportMapRequest::OCTOMAP_FULL);
  request.set_component(3);
  EXPECT_GRPC_OK(Export(request));
  request.set_format(v1::ExportMapRequest::PCD_BINARY_COMPRESSED);
  request.set_resolution_m(0.5);
  *request.mutable_box() = BoxFrom(2, 5).box();
  request.set_robot("bob");
  EXPECT_GRPC_OK(Export(request));
  request.mutable_sphere()->set_radius_m(3);
  EXPECT_GRPC_OK(Export(request));
  ASSERT_EQ(pipeline_.exports.size(), 3u);
  EXPECT_EQ(pipeline_.exports[0].format, ExportFormat::kOctoMapFull);
  EXPECT_EQ(pipeline_.exports[0].component, 3u);
  EXPECT_EQ(pipeline_.exports[0].resolution_m, 0);
  EXPECT_FALSE(pipeline_.exports[0].box || pipeline_.exports[0].sphere);
  EXPECT_EQ(pipeline_.exports[1].format, ExportFormat::kPcdBinaryCompressed);
  EXPECT_EQ(pipeline_.exports[1].resolution_m, 0.5);
  ASSERT_TRUE(pipeline_.exports[1].box);
  EXPECT_EQ(pipeline_.exports[1].box->max.x(), 5);
  EXPECT_EQ(pipeline_.exports[1].robot, RobotId("bob"));
  ASSERT_TRUE(pipeline_.exports[2].sphere);
  EXPECT_EQ(pipeline_.exports[2].sphere->radius_m, 3);
  EXPECT_TRUE(responses_.back().last());
}

TEST_F(ExportMapTest, AFailureInTheMiddleHasNoLastResponse) {
  pipeline_.file = {"part"};
  pipeline_.export_status = absl::ResourceExhaustedError("ask for a coarser one");
  EXPECT_GRPC_ERROR(Export(Ply()), RESOURCE_EXHAUSTED, "coarser");
  ASSERT_EQ(responses_.size(), 1u);
  EXPECT_FALSE(responses_[0].last());
}

TEST_F(ExportMapTest, RequestsThatMakeNoSense) {
  EXPECT_GRPC_ERROR(Export({}), INVALID_ARGUMENT, "PCD_ASCII");
  v1::ExportMapRequest boxed = Ply();
  *boxed.mutable_box() = BoxFrom(5, 2).box();
  EXPECT_GRPC_ERROR(Export(boxed), INVALID_ARGUMENT, "exceeds box.max");
  v1::ExportMapRequest request = Ply();
  for (const double resolution : {-1.0, kNaN}) {
    request.set_resolution_m(resolution);
    EXPECT_GRPC_ERROR(Export(request), INVALID_ARGUMENT, "resolution_m");
  }
  request.set_format(v1::ExportMapRequest::OCTOMAP_FULL);
  for (const double leaf : {-1.0, 1e-9, 10.5, kNaN}) {
    request.set_resolution_m(leaf);
    EXPECT_GRPC_ERROR(Export(request), INVALID_ARGUMENT, "give 0.01 to 10 m");
  }
  pipeline_.export_status = absl::NotFoundError("no component 8");
  EXPECT_GRPC_ERROR(Export(Ply()), NOT_FOUND, "component 8");
}

TEST_F(ExportMapTest, AReaderThatGoesAwayEndsTheExport) {
  pipeline_.file.assign(48, std::string(1 << 20, 'x'));
  auto context = NewContext();
  auto reader = stubs_->map->ExportMap(context.get(), Ply());
  v1::ExportMapResponse response;
  ASSERT_TRUE(reader->Read(&response));
  context->TryCancel();
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
  // Others are served.
  v1::MapInfo info;
  EXPECT_GRPC_OK(stubs_->map->GetMapInfo(NewContext().get(), {}, &info));
}

}  // namespace
}  // namespace isthmus::rpc
