#include "server/web/vehicle_maps.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_split.h>
#include <absl/strings/strip.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/records/map_tracks.h"
#include "server/map/map_view.h"
#include "server/web/answers.h"
#include "server/web/map_files.h"
#include "server/web/map_query.h"
#include "server/web/map_read.h"

namespace isthmus::web {
namespace {

using nlohmann::ordered_json;

struct MapAddress {
  MapName map;
  std::string file;
};

// False where the path names no file.
bool ReadMapAddress(absl::string_view path, MapAddress* address) {
  absl::ConsumePrefix(&path, "/vda5050/");
  const std::vector<std::string> parts = absl::StrSplit(path, '/');
  if (parts.size() != 2 || parts[0].empty()) return false;
  address->map = MapName::FromText(parts[0]);
  address->file = parts[1];
  return MapFileFormat(address->file).has_value();
}

// Numbers anew: what was sent might not be fit for an address.
std::string LinkOf(const http::Request& request, const MapAddress& address,
                   const v1::ExportMapRequest& wanted, int64_t revision) {
  std::string link = absl::StrCat(
      request.is_tls ? "https" : "http", "://", request.Header("host").value_or("localhost"),
      "/export/", address.file, "?map=", address.map.ToText(), "&revision=", revision);
  if (wanted.resolution_m() != 0) absl::StrAppend(&link, "&resolution=", wanted.resolution_m());
  if (wanted.has_box()) {
    const v1::Vector3& min = wanted.box().min();
    const v1::Vector3& max = wanted.box().max();
    absl::StrAppendFormat(&link, "&box=%.3f,%.3f,%.3f,%.3f,%.3f,%.3f", min.x(), min.y(), min.z(),
                          max.x(), max.y(), max.z());
  }
  return link;
}

// The revision of the file as it would be made now: clouds are the composed map, which follows a
// new revision; OctoMaps are made of the submaps where they lie.
absl::StatusOr<int64_t> RevisionOf(const MapAddress& address, const MapInfo& info,
                                   const ComposedMap& map) {
  const auto format = MapFileFormat(address.file);
  if (format == v1::ExportMapRequest::OCTOMAP_BINARY ||
      format == v1::ExportMapRequest::OCTOMAP_FULL) {
    return info.revision;
  }
  if (absl::Status ready = map.ready(); !ready.ok()) return ready;
  const auto number = map.NumberOf(address.map);
  if (!number.ok()) return number.status();
  return map.revision();
}

ordered_json Parameter(const std::string& key, const std::string& value) {
  return {{"key", key}, {"value", value}};
}

absl::StatusOr<http::Response> MakeAction(const http::Request& request, const rpc::Call& call,
                                          MapAddress address, const v1::ExportMapRequest& wanted) {
  const server::MapReader& reader = call.pipeline().reader();
  const std::shared_ptr<const server::MapView> view = reader.View();
  const MapInfo info = reader.Describe(*view);
  // The link is to mean this map for as long as it holds.
  const auto name = StableName(info, address.map);
  if (!name.ok()) return name.status();
  if (info.components.empty()) return absl::NotFoundError("there is no map yet");
  address.map = *name;
  const auto revision = RevisionOf(address, info, *view->map);
  if (!revision.ok()) return revision.status();
  const ordered_json parameters = {
      Parameter("mapId", address.map.ToText()), Parameter("mapVersion", absl::StrCat(*revision)),
      Parameter("mapDownloadLink", LinkOf(request, address, wanted, *revision))};
  return JsonAnswer(ordered_json{
      {"actionType", "downloadMap"}, {"blockingType", "NONE"}, {"actionParameters", parameters}}
                        .dump());
}

}  // namespace

http::Response AnswerDownloadMap(const http::Request& request, rpc::Gate& gate) {
  if (request.method != "GET") return WrongMethod("GET");
  MapAddress address;
  if (!ReadMapAddress(request.path, &address)) {
    return ErrorAnswer(absl::NotFoundError(
        "the action downloadMap is at /vda5050/MAP/map.pcd, map.ply, map.bt and map.ot"));
  }
  v1::ExportMapRequest wanted;
  wanted.set_format(*MapFileFormat(address.file));
  absl::Status asked = CheckQuery(request, {"resolution", "box"});
  if (asked.ok()) asked = ReadMapQuery(request, &wanted);
  if (!asked.ok()) return ErrorAnswer(asked);
  return ReadMap(gate, request, "GetMapInfo", v1::GetMapInfoRequest(),
                 [&](const rpc::Call& call) { return MakeAction(request, call, address, wanted); });
}

}  // namespace isthmus::web
