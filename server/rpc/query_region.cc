#include "server/rpc/query_region.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>

#include "server/rpc/convert.h"

namespace isthmus::rpc {
namespace {

// MapPoint is sent as it lies in memory.
static_assert(sizeof(MapPoint) == 20 && offsetof(MapPoint, robot) == 16);
static_assert(std::endian::native == std::endian::little);

constexpr size_t kChunkPoints = (1 << 20) / sizeof(MapPoint);

void AddField(const char* name, uint32_t offset, v1::PointField::Type type, v1::PointCloud& cloud) {
  v1::PointField& field = *cloud.add_fields();
  field.set_name(name);
  field.set_offset(offset);
  field.set_type(type);
  field.set_count(1);
}

v1::PointCloud ToProto(const std::vector<MapPoint>& points) {
  v1::PointCloud cloud;
  cloud.set_encoding(v1::PointCloud::RAW);
  cloud.set_width(static_cast<uint32_t>(points.size()));
  cloud.set_height(1);
  cloud.set_stride(sizeof(MapPoint));
  AddField("x", offsetof(MapPoint, x), v1::PointField::FLOAT32, cloud);
  AddField("y", offsetof(MapPoint, y), v1::PointField::FLOAT32, cloud);
  AddField("z", offsetof(MapPoint, z), v1::PointField::FLOAT32, cloud);
  AddField("intensity", offsetof(MapPoint, intensity), v1::PointField::FLOAT32, cloud);
  AddField("robot", offsetof(MapPoint, robot), v1::PointField::UINT32, cloud);
  cloud.set_data(points.data(), points.size() * sizeof(MapPoint));
  return cloud;
}

absl::Status SetBox(const v1::Box& box, Region& region) {
  const auto min = rpc::FromProto(box.min(), "box.min");
  if (!min.ok()) return min.status();
  const auto max = rpc::FromProto(box.max(), "box.max");
  if (!max.ok()) return max.status();
  if ((min->array() > max->array()).any()) {
    return absl::InvalidArgumentError(absl::StrCat("box.min (", min->x(), ", ", min->y(), ", ",
                                                   min->z(), ") exceeds box.max (", max->x(), ", ",
                                                   max->y(), ", ", max->z(), "): exchange them"));
  }
  region.box.min = *min;
  region.box.max = *max;
  return absl::OkStatus();
}

absl::Status SetSphere(const v1::Sphere& sphere, Region& region) {
  const auto center = rpc::FromProto(sphere.center(), "sphere.center");
  if (!center.ok()) return center.status();
  // Written so that NaN fails too.
  if (!(sphere.radius_m() > 0 && sphere.radius_m() <= kMaxCoordinateM)) {
    return absl::InvalidArgumentError(
        absl::StrCat("sphere.radius_m is ", sphere.radius_m(), ": give a positive number"));
  }
  region.has_sphere = true;
  region.center = *center;
  region.radius_m = sphere.radius_m();
  return absl::OkStatus();
}

absl::StatusOr<Region> FromProto(const v1::QueryRegionRequest& request) {
  Region region;
  absl::Status status;
  if (request.has_box()) status = SetBox(request.box(), region);
  if (request.has_sphere()) status = SetSphere(request.sphere(), region);
  if (!status.ok()) return status;
  if (!(request.resolution_m() >= 0 && request.resolution_m() <= kMaxCoordinateM)) {
    return absl::InvalidArgumentError(
        absl::StrCat("resolution_m is ", request.resolution_m(),
                     ": give a positive voxel size, or 0 for the points as composed"));
  }
  region.component = request.component();
  region.resolution_m = request.resolution_m();
  return region;
}

// Sets region.robot. Returns false for a robot that is known but has no points in this map yet.
absl::StatusOr<bool> FindRobot(server::Pipeline& pipeline, const ComposedMap& map,
                               const RobotId& robot, Region& region) {
  const auto& placed = map.robots();
  const auto found = std::find(placed.begin(), placed.end(), robot);
  if (found != placed.end()) {
    region.robot = static_cast<int>(found - placed.begin());
    return true;
  }
  const auto known = pipeline.GetMapInfo().robots;
  if (std::find(known.begin(), known.end(), robot) != known.end()) return false;
  return absl::NotFoundError(absl::StrCat("no robot \"", robot.value(), "\" in this map"));
}

}  // namespace

absl::Status QueryRegion(server::Pipeline& pipeline, const v1::QueryRegionRequest& request,
                         const Emit<v1::QueryRegionResponse>& emit) {
  auto region = FromProto(request);
  if (!region.ok()) return region.status();
  const std::shared_ptr<const ComposedMap> map = pipeline.GetMap();
  if (absl::Status ready = map->ready(); !ready.ok()) return ready;
  // Component 0 may always be asked: in an empty map it has no points.
  if (region->component != 0 && region->component >= map->component_count()) {
    return absl::NotFoundError(absl::StrCat("no component ", region->component, ": the map has ",
                                            map->component_count(), ", counted from 0"));
  }
  absl::StatusOr<bool> has_points = true;
  if (!request.robot().empty()) {
    has_points = FindRobot(pipeline, *map, RobotId(request.robot()), *region);
    if (!has_points.ok()) return has_points.status();
  }
  v1::QueryRegionResponse response;
  response.set_revision(map->revision());
  for (const RobotId& robot : map->robots()) response.add_robots(robot.value());
  *response.mutable_cloud() = ToProto(std::vector<MapPoint>());
  if (!emit(response)) return ReaderGone();
  response.clear_robots();
  bool reading = true;
  const auto send = [&](const std::vector<MapPoint>& points) {
    *response.mutable_cloud() = ToProto(points);
    return reading = emit(response);
  };
  absl::Status status;
  if (*has_points) status = map->Read(*region, kChunkPoints, send);
  return reading ? status : ReaderGone();
}

}  // namespace isthmus::rpc
