// Points of the merged map, and the map and its pose graph as files.
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "api/convert/cloud.h"
#include "api/convert/map.h"
#include "server/rpc/map_service.h"
#include "server/rpc/responses.h"

namespace isthmus::rpc {
namespace {

constexpr size_t kChunkPoints = kResponseBytes / kMapRecordBytes;

Region RegionOf(const RegionQuery& query) {
  Region region;
  if (query.box) region.box = *query.box;
  if (query.sphere) {
    region.has_sphere = true;
    region.center = query.sphere->center;
    region.radius_m = query.sphere->radius_m;
  }
  region.component = query.component;
  region.resolution_m = query.resolution_m;
  return region;
}

// Sets region.robot. Returns false for a robot that is known but has no points in this map yet.
absl::StatusOr<bool> FindRobot(server::Pipeline& pipeline, const ComposedMap& map,
                               const RobotId& robot, Region& region) {
  if (robot.empty()) return true;
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

absl::Status MapService::SendRegion(const Call& call, const v1::QueryRegionRequest& request,
                                    grpc::ServerWriter<v1::QueryRegionResponse>* writer) {
  const auto query = convert::FromMessage(request);
  if (!query.ok()) return query.status();
  const std::shared_ptr<const ComposedMap> map = call.pipeline().GetMap();
  if (absl::Status ready = map->ready(); !ready.ok()) return ready;
  // Component 0 may always be asked: in an empty map it has no points.
  if (query->component != 0 && query->component >= map->component_count()) {
    return absl::NotFoundError(absl::StrCat("no component ", query->component, ": the map has ",
                                            map->component_count(), ", counted from 0"));
  }
  Region region = RegionOf(*query);
  const absl::StatusOr<bool> has_points = FindRobot(call.pipeline(), *map, query->robot, region);
  if (!has_points.ok()) return has_points.status();
  v1::QueryRegionResponse response;
  response.set_revision(map->revision());
  for (const RobotId& robot : map->robots()) response.add_robots(robot.value());
  *response.mutable_cloud() = convert::ToMessage(std::vector<MapPoint>());
  if (!writer->Write(response)) return ReaderGone();
  response.clear_robots();
  bool reading = true;
  const auto send = [&](const std::vector<MapPoint>& points) {
    *response.mutable_cloud() = convert::ToMessage(points);
    return reading = call.Allowed().ok() && !call.Gone() && writer->Write(response);
  };
  absl::Status status;
  if (*has_points) status = map->Read(region, kChunkPoints, send);
  return reading ? status : ReaderGone();
}

grpc::Status MapService::QueryRegion(grpc::ServerContext* context,
                                     const v1::QueryRegionRequest* request,
                                     grpc::ServerWriter<v1::QueryRegionResponse>* writer) {
  return gate_.Serve(context, "QueryRegion",
                     [&](const Call& call) { return SendRegion(call, *request, writer); });
}

absl::Status MapService::SendMap(const Call& call, const v1::ExportMapRequest& request,
                                 grpc::ServerWriter<v1::ExportMapResponse>* writer) {
  const auto wanted = convert::FromMessage(request);
  if (!wanted.ok()) return wanted.status();
  FileEmitter<v1::ExportMapResponse> file(call, call.pipeline().GetMap()->revision(), writer);
  const absl::Status status = call.pipeline().ExportMap(
      *wanted, [&](const std::string& piece) { return !call.Gone() && file.Add(piece); });
  return status.ok() ? file.Finish() : status;
}

grpc::Status MapService::ExportMap(grpc::ServerContext* context,
                                   const v1::ExportMapRequest* request,
                                   grpc::ServerWriter<v1::ExportMapResponse>* writer) {
  return gate_.Serve(context, "ExportMap",
                     [&](const Call& call) { return SendMap(call, *request, writer); });
}

grpc::Status MapService::ExportPoseGraph(grpc::ServerContext* context,
                                         const v1::ExportPoseGraphRequest* request,
                                         grpc::ServerWriter<v1::ExportPoseGraphResponse>* writer) {
  return gate_.Serve(context, "ExportPoseGraph", [&](const Call& call) -> absl::Status {
    FileEmitter<v1::ExportPoseGraphResponse> file(call, call.pipeline().GetMapInfo().revision,
                                                  writer);
    const absl::StatusOr<std::string> graph = call.pipeline().ExportPoseGraph(request->component());
    if (!graph.ok()) return graph.status();
    return file.Add(*graph) ? file.Finish() : ReaderGone();
  });
}

}  // namespace isthmus::rpc
