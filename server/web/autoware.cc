#include "server/web/autoware.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/strings/strip.h>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/convert/map_name.h"
#include "core/formats/autoware.h"
#include "core/formats/map_writer.h"
#include "core/map/composed_map.h"
#include "isthmus/v1/map_service.pb.h"
#include "server/web/answers.h"
#include "server/web/limits.h"
#include "server/web/map_files.h"
#include "server/web/map_query.h"
#include "server/web/map_read.h"

namespace isthmus::web {
namespace {

constexpr char kMetadata[] = "pointcloud_map_metadata.yaml";

// One map that the caller may read, by its cells.
struct Cells {
  std::shared_ptr<const ComposedMap> map;
  uint32_t component = 0;
  int64_t edge_m = 0;
};

absl::StatusOr<Cells> CellsOf(const rpc::Call& call, const MapName& name) {
  const std::shared_ptr<const ComposedMap> map = call.pipeline().reader().Map();
  if (absl::Status ready = map->ready(); !ready.ok()) return ready;
  const auto number = map->NumberOf(name);
  if (!number.ok()) return number.status();
  // Tiles are whole voxels, so 20 m may be off by a rounding.
  const double edge_m = std::round(map->tile_m());
  if (edge_m < 1 || std::abs(map->tile_m() - edge_m) > 1e-6) {
    return absl::FailedPreconditionError(
        absl::StrCat("tiles of ", map->tile_m(),
                     " m: Autoware's map loader takes cells of whole metres; set "
                     "composition.tile_m, or use isthmus export --format autoware --tile"));
  }
  return Cells{map, *number, static_cast<int64_t>(edge_m)};
}

absl::Status NoSuchCell() {
  return absl::NotFoundError(
      "Autoware's map is at /autoware/MAP/pointcloud_map_metadata.yaml, and the cells that "
      "it lists at /autoware/MAP/pointcloud_map/X_Y.pcd");
}

// The tile that is the cell of that file name.
absl::StatusOr<TileId> TileOf(const Cells& cells, const std::string& file) {
  const std::optional<formats::CellCorner> corner = formats::ReadCellFileName(file);
  if (!corner || corner->first % cells.edge_m != 0 || corner->second % cells.edge_m != 0) {
    return NoSuchCell();
  }
  const auto x = static_cast<int32_t>(corner->first / cells.edge_m);
  const auto y = static_cast<int32_t>(corner->second / cells.edge_m);
  const TileId id{cells.component, 0, x, y};
  const absl::Status found = cells.map->FindTile(id).status();
  if (absl::IsNotFound(found)) return NoSuchCell();
  if (!found.ok()) return found;
  return id;
}

// Points have floats: the last one before the next cell.
double LastBefore(int64_t edge_m) {
  return std::nextafter(static_cast<float>(edge_m), -std::numeric_limits<float>::infinity());
}

Box BoxOf(const TileId& cell, int64_t edge_m) {
  const int64_t x = cell.x * edge_m, y = cell.y * edge_m;
  Box box;
  box.min = {static_cast<double>(x), static_cast<double>(y), -kEndlessM};
  box.max = {LastBefore(x + edge_m), LastBefore(y + edge_m), kEndlessM};
  return box;
}

// Neighbours may hold points on the cell's edges: what tile a voxel is on is rounded.
absl::StatusOr<std::vector<MapPoint>> PointsOf(const Cells& cells, const TileId& cell) {
  const Box box = BoxOf(cell, cells.edge_m);
  std::vector<MapPoint> points;
  for (const int dx : {-1, 0, 1}) {
    for (const int dy : {-1, 0, 1}) {
      const TileId id{cell.component, 0, cell.x + dx, cell.y + dy};
      const auto info = cells.map->FindTile(id);
      if (absl::IsNotFound(info.status())) continue;
      if (!info.ok()) return info.status();
      if (!box.Intersects(info->bounds)) continue;
      const auto tile = cells.map->ReadTile(id);
      if (!tile.ok()) return tile.status();
      for (const MapPoint& p : *tile) {
        if (box.Contains(Eigen::Vector3d(p.x, p.y, p.z))) points.push_back(p);
      }
    }
  }
  return points;
}

// A file that is sent from memory.
class CellSource final : public http::Source {
 public:
  CellSource(std::string file, std::unique_ptr<StreamSlots::Slot> slot)
      : slot_(std::move(slot)), file_(std::move(file)) {}

  Next Take(std::string* piece) override {
    if (file_.empty()) return Next::kEnd;
    *piece = std::exchange(file_, "");
    return Next::kPiece;
  }

 private:
  const std::unique_ptr<StreamSlots::Slot> slot_;
  std::string file_;
};

absl::StatusOr<http::Response> SendCell(const Cells& cells, const std::string& name,
                                        std::unique_ptr<StreamSlots::Slot> slot) {
  const auto tile = TileOf(cells, name);
  if (!tile.ok()) return tile.status();
  const auto points = PointsOf(cells, *tile);
  if (!points.ok()) return points.status();
  constexpr auto kEncoding = formats::PcdEncoding::kBinary;
  std::string file = formats::PcdMapHeader(points->size(), kEncoding, cells.map->robots());
  file += formats::PcdMapChunk(*points, kEncoding);
  http::Response response = FileAnswer(name, cells.map->revision());
  response.source = std::make_unique<CellSource>(std::move(file), std::move(slot));
  return response;
}

http::Response ListCells(const http::Request& request, rpc::Gate& gate, const MapName& map) {
  v1::ListTilesRequest asked;
  convert::PutMap(map, asked);
  return ReadMap(gate, request, "ListTiles", asked,
                 [&map](const rpc::Call& call) -> absl::StatusOr<http::Response> {
                   const auto cells = CellsOf(call, map);
                   if (!cells.ok()) return cells.status();
                   std::vector<formats::CellCorner> corners;
                   for (const TileInfo& tile : cells->map->Tiles(cells->component, 0)) {
                     corners.emplace_back(tile.id.x * cells->edge_m, tile.id.y * cells->edge_m);
                   }
                   return TextAnswer(formats::FormatCellList(cells->edge_m, corners));
                 });
}

}  // namespace

http::Response AnswerAutoware(const http::Request& request, rpc::Gate& gate, StreamSlots* slots) {
  if (request.method != "GET") return WrongMethod("GET");
  if (absl::Status known = CheckQuery(request, {}); !known.ok()) return ErrorAnswer(known);
  absl::string_view path = request.path;
  absl::ConsumePrefix(&path, "/autoware/");
  const std::vector<std::string> parts = absl::StrSplit(path, '/');
  const bool is_metadata = parts.size() == 2 && parts[1] == kMetadata;
  if (parts[0].empty() || !(is_metadata || (parts.size() == 3 && parts[1] == "pointcloud_map"))) {
    return ErrorAnswer(NoSuchCell());
  }
  const auto map = MapName::FromText(parts[0]);
  if (is_metadata) return ListCells(request, gate, map);
  v1::GetTileRequest asked;
  asked.set_map(map.session().value());
  return ReadMap(gate, request, "GetTile", asked,
                 [&](const rpc::Call& call) -> absl::StatusOr<http::Response> {
                   const auto cells = CellsOf(call, map);
                   if (!cells.ok()) return cells.status();
                   auto slot = slots->Take(request.peer);
                   if (slot == nullptr) return NoSlotLeft();
                   return SendCell(*cells, parts[2], std::move(slot));
                 });
}

}  // namespace isthmus::web
