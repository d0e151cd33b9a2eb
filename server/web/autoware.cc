#include "server/web/autoware.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/strings/strip.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "api/convert/map_name.h"
#include "core/formats/autoware.h"
#include "server/web/answers.h"
#include "server/web/limits.h"
#include "server/web/map_calls.h"
#include "server/web/map_files.h"

namespace isthmus::web {
namespace {

constexpr char kMetadata[] = "pointcloud_map_metadata.yaml";

struct Cells {
  int64_t edge_m = 0;
  std::vector<formats::CellCorner> corners;
};

absl::StatusOr<Cells> ListCells(const MapCalls& calls, const MapName& map) {
  const auto list = calls.ListTiles(map);
  if (!list.ok()) return list.status();
  // Tiles are whole voxels, so 20 m may be off by a rounding.
  const double edge_m = std::round(list->tile_m);
  if (edge_m < 1 || std::abs(list->tile_m - edge_m) > 1e-6) {
    return absl::FailedPreconditionError(
        absl::StrCat("tiles of ", list->tile_m,
                     " m: Autoware's map loader takes cells of whole metres; set "
                     "composition.tile_m, or use isthmus export --format autoware --tile"));
  }
  Cells cells{static_cast<int64_t>(edge_m), {}};
  for (const v1::TileId& tile : list->tiles) {
    cells.corners.emplace_back(tile.x() * cells.edge_m, tile.y() * cells.edge_m);
  }
  return cells;
}

// Points have floats: the last one before the next cell.
double LastBefore(int64_t edge_m) {
  return std::nextafter(static_cast<float>(edge_m), -std::numeric_limits<float>::infinity());
}

v1::ExportMapRequest CellAt(const MapName& map, const formats::CellCorner& corner, int64_t edge_m) {
  const auto& [x, y] = corner;
  v1::ExportMapRequest wanted;
  convert::PutMap(map, wanted);
  wanted.set_format(v1::ExportMapRequest::PCD_BINARY);
  v1::Vector3* min = wanted.mutable_box()->mutable_min();
  v1::Vector3* max = wanted.mutable_box()->mutable_max();
  min->set_x(static_cast<double>(x));
  min->set_y(static_cast<double>(y));
  min->set_z(-kEndlessM);
  max->set_x(LastBefore(x + edge_m));
  max->set_y(LastBefore(y + edge_m));
  max->set_z(kEndlessM);
  return wanted;
}

http::Response NoSuchCell() {
  return ErrorAnswer(absl::NotFoundError(
      "Autoware's map is at /autoware/MAP/pointcloud_map_metadata.yaml, and the cells that "
      "it lists at /autoware/MAP/pointcloud_map/X_Y.pcd"));
}

}  // namespace

http::Response AnswerAutoware(const http::Request& request,
                              const std::shared_ptr<grpc::Channel>& channel, StreamSlots* slots) {
  if (request.method != "GET") return WrongMethod("GET");
  absl::string_view path = request.path;
  absl::ConsumePrefix(&path, "/autoware/");
  const std::vector<std::string> parts = absl::StrSplit(path, '/');
  const bool is_metadata = parts.size() == 2 && parts[1] == kMetadata;
  if (parts[0].empty() || !(is_metadata || (parts.size() == 3 && parts[1] == "pointcloud_map"))) {
    return NoSuchCell();
  }
  const auto map = MapName::FromText(parts[0]);
  const auto cells = ListCells(MapCalls(request, channel), map);
  if (!cells.ok()) return ErrorAnswer(cells.status());
  if (is_metadata) return TextAnswer(formats::FormatCellList(cells->edge_m, cells->corners));
  for (const formats::CellCorner& corner : cells->corners) {
    if (parts[2] != formats::CellFileName(corner)) continue;
    return SendMapFile(request, channel, CellAt(map, corner, cells->edge_m), parts[2], slots);
  }
  return NoSuchCell();
}

}  // namespace isthmus::web
