// Tiles of the merged map.
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "api/convert/cloud.h"
#include "api/convert/map_changes.h"
#include "api/convert/map_name.h"
#include "core/codec/tile_points.h"
#include "server/rpc/map_answers.h"
#include "server/rpc/responses.h"

namespace isthmus::rpc {
namespace {

using TileWriter = grpc::ServerWriter<v1::GetTileResponse>;

bool SendPieces(const Call& call, const std::string& bytes, v1::GetTileResponse response,
                TileWriter* writer) {
  for (size_t at = 0; at == 0 || at < bytes.size(); at += kResponseBytes) {
    response.set_points(bytes.substr(at, kResponseBytes));
    if (!call.Allowed().ok() || !writer->Write(response)) return false;
    response.clear_info();
    response.clear_robots();
  }
  return true;
}

bool SendCloud(const Call& call, const std::vector<MapPoint>& points, v1::GetTileResponse response,
               TileWriter* writer) {
  for (size_t at = 0; at == 0 || at < points.size(); at += kResponsePoints) {
    const auto begin = points.begin() + static_cast<std::ptrdiff_t>(at);
    const auto count = static_cast<std::ptrdiff_t>(std::min(kResponsePoints, points.size() - at));
    *response.mutable_cloud() = convert::ToMessage(
        convert::ToPayload({begin, begin + count}, {true, true, true, /*label=*/true}));
    if (!call.Allowed().ok() || !writer->Write(response)) return false;
    response.clear_info();
    response.clear_robots();
  }
  return true;
}

// Makes the points' robots indices into those that occur among them, which it returns: what is sent
// depends on the tile alone then, and not on who else is in the map.
std::vector<RobotId> NameOwnRobots(const std::vector<RobotId>& all, std::vector<MapPoint>* points) {
  constexpr uint32_t kNone = ~uint32_t{0};
  std::vector<uint32_t> own(all.size(), kNone);
  for (const MapPoint& point : *points) {
    if (point.robot < own.size()) own[point.robot] = 0;
  }
  std::vector<RobotId> names;
  for (size_t i = 0; i < all.size(); ++i) {
    if (own[i] == kNone) continue;
    own[i] = static_cast<uint32_t>(names.size());
    names.push_back(all[i]);
  }
  for (MapPoint& point : *points) {
    if (point.robot < own.size()) point.robot = own[point.robot];
  }
  return names;
}

absl::Status NoTile(const TileId& id) {
  return absl::NotFoundError(
      absl::StrCat("no tile ", id.x, ", ", id.y, " of level ", id.level, " in map ", id.component));
}

}  // namespace

absl::Status SendTiles(const Call& call, const v1::ListTilesRequest& request,
                       grpc::ServerWriter<v1::ListTilesResponse>* writer) {
  const std::shared_ptr<const ComposedMap> map = call.pipeline().reader().Map();
  if (absl::Status ready = map->ready(); !ready.ok()) return ready;
  const auto number = map->NumberOf(convert::MapOf(request));
  if (!number.ok()) return number.status();
  const uint32_t levels = map->tile_levels(*number);
  if (request.level() >= std::max<uint32_t>(levels, 1)) {
    return absl::InvalidArgumentError(
        absl::StrCat("no level ", request.level(), ": the map has ", levels, ", counted from 0"));
  }
  v1::ListTilesResponse head;
  head.set_revision(map->revision());
  head.set_tile_m(map->tile_m());
  head.set_levels(levels);
  ListEmitter<v1::ListTilesResponse> list(call, head, writer);
  for (const TileInfo& tile : map->Tiles(*number, request.level())) {
    list.Add(&v1::ListTilesResponse::mutable_tiles, convert::ToMessage(tile));
  }
  return list.Finish();
}

absl::Status SendTile(const Call& call, const v1::GetTileRequest& request, TileWriter* writer) {
  if (!request.has_id()) return absl::InvalidArgumentError("name a tile: id is missing");
  if (!v1::GetTileRequest::Form_IsValid(request.form())) {
    return absl::InvalidArgumentError(
        absl::StrCat("form ", static_cast<int>(request.form()), " is not known to this server"));
  }
  TileId id = convert::FromMessage(request.id());
  const std::shared_ptr<const ComposedMap> map = call.pipeline().reader().Map();
  if (absl::Status ready = map->ready(); !ready.ok()) return ready;
  if (!request.map().empty()) {
    const auto number = map->NumberOf(MapName(SessionId(request.map())));
    if (!number.ok()) return number.status();
    id.component = *number;
  }
  const bool has_level = id.level < map->tile_levels(id.component);
  const absl::StatusOr<TileInfo> info = has_level ? map->FindTile(id) : NoTile(id);
  if (absl::IsNotFound(info.status())) return NoTile(id);
  if (!info.ok()) return info.status();
  v1::GetTileResponse response;
  *response.mutable_info() = convert::ToMessage(*info);
  response.set_revision(map->revision());
  if (request.have_version() != 0 && request.have_version() == info->version) {
    response.set_not_modified(true);
    return writer->Write(response) ? absl::OkStatus() : ReaderGone();
  }
  auto points = map->ReadTile(id);
  if (!points.ok()) return points.status();
  for (const RobotId& robot : NameOwnRobots(map->robots(), &*points)) {
    response.add_robots(robot.value());
  }
  const bool sent =
      request.form() == v1::GetTileRequest::CLOUD
          ? SendCloud(call, *points, std::move(response), writer)
          : SendPieces(call, codec::WriteTilePoints(*points), std::move(response), writer);
  return sent ? absl::OkStatus() : ReaderGone();
}

}  // namespace isthmus::rpc
