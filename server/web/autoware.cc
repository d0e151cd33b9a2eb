#include "server/web/autoware.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/strings/strip.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "server/web/answers.h"
#include "server/web/limits.h"
#include "server/web/map_calls.h"
#include "server/web/map_files.h"

namespace isthmus::web {
namespace {

constexpr char kMetadata[] = "pointcloud_map_metadata.yaml";

struct Cells {
  int64_t edge_m = 0;
  std::vector<v1::TileId> tiles;
};

absl::StatusOr<Cells> ListCells(const MapCalls& calls, uint32_t component) {
  auto list = calls.ListTiles(component);
  if (!list.ok()) return list.status();
  // Tiles are whole voxels, so 20 m may be off by a rounding.
  const double edge_m = std::round(list->tile_m);
  if (edge_m < 1 || std::abs(list->tile_m - edge_m) > 1e-6) {
    return absl::FailedPreconditionError(
        absl::StrCat("tiles of ", list->tile_m,
                     " m: Autoware's map loader takes cells of whole metres; set "
                     "composition.tile_m, or use isthmus export --format autoware --tile"));
  }
  return Cells{static_cast<int64_t>(edge_m), std::move(list->tiles)};
}

http::Response MetadataOf(const Cells& cells) {
  std::string yaml =
      absl::StrCat("x_resolution: ", cells.edge_m, ".0\ny_resolution: ", cells.edge_m, ".0\n");
  for (const v1::TileId& tile : cells.tiles) {
    const int64_t x = tile.x() * cells.edge_m, y = tile.y() * cells.edge_m;
    absl::StrAppend(&yaml, x, "_", y, ".pcd: [", x, ", ", y, "]\n");
  }
  http::Response response;
  response.Set("Content-Type", "text/plain; charset=utf-8");
  response.Set("Cache-Control", "no-store");
  response.body = std::move(yaml);
  return response;
}

// Points have floats: the last one before the next cell.
double LastBefore(int64_t edge_m) {
  return std::nextafter(static_cast<float>(edge_m), -std::numeric_limits<float>::infinity());
}

v1::ExportMapRequest CellAt(uint32_t component, int64_t x, int64_t y, int64_t edge_m) {
  v1::ExportMapRequest wanted;
  wanted.set_component(component);
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
      "Autoware's map is at /autoware/COMPONENT/pointcloud_map_metadata.yaml, and the cells that "
      "it lists at /autoware/COMPONENT/pointcloud_map/X_Y.pcd"));
}

}  // namespace

http::Response AnswerAutoware(const http::Request& request,
                              const std::shared_ptr<grpc::Channel>& channel, StreamSlots* slots) {
  if (request.method != "GET") return WrongMethod("GET");
  absl::string_view path = request.path;
  absl::ConsumePrefix(&path, "/autoware/");
  const std::vector<std::string> parts = absl::StrSplit(path, '/');
  uint32_t component = 0;
  const bool is_metadata = parts.size() == 2 && parts[1] == kMetadata;
  if (!absl::SimpleAtoi(parts[0], &component) ||
      !(is_metadata || (parts.size() == 3 && parts[1] == "pointcloud_map"))) {
    return NoSuchCell();
  }
  const auto cells = ListCells(MapCalls(request, channel), component);
  if (!cells.ok()) return ErrorAnswer(cells.status());
  if (is_metadata) return MetadataOf(*cells);
  for (const v1::TileId& tile : cells->tiles) {
    const int64_t x = tile.x() * cells->edge_m, y = tile.y() * cells->edge_m;
    if (parts[2] != absl::StrCat(x, "_", y, ".pcd")) continue;
    return SendMapFile(request, channel, CellAt(component, x, y, cells->edge_m), parts[2], slots);
  }
  return NoSuchCell();
}

}  // namespace isthmus::web
