#include "client/cli/grid_export.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <filesystem>

#include "client/console/console.h"
#include "client/exports/tracks.h"
#include "core/floors/rooms.h"
#include "core/floors/rooms_file.h"
#include "core/io/output_file.h"

namespace isthmus::cli {
namespace {

// It is kept in memory, as a tree of four times the size: some 1e9 voxels.
constexpr size_t kMostOctomapBytes = size_t{256} << 20;
// Metres: maps end long before it.
constexpr double kEndlessM = 1e7;

// The free space of those heights alone, so that the server keeps no more in memory.
absl::StatusOr<std::string> ReadOctomap(client::Client& client, const RegionQuery& query,
                                        const floors::HeightBand& heights) {
  ExportRequest request{.format = ExportFormat::kOctoMapBinary,
                        .component = query.component,
                        .resolution_m = query.resolution_m,
                        .box = query.box.value_or(Box{Eigen::Vector3d::Constant(-kEndlessM),
                                                      Eigen::Vector3d::Constant(kEndlessM)}),
                        .robot = query.robot};
  request.box->min.z() = std::max(request.box->min.z(), heights.lowest_m);
  request.box->max.z() = std::min(request.box->max.z(), heights.highest_m);
  std::string octomap;
  // A floor that the box leaves out has no voxels; the server would call the box empty.
  if (request.box->min.z() > request.box->max.z()) return octomap;
  Progress progress("free space", 0);
  const auto read = client.Export(request, [&](const std::string& bytes) {
    octomap += bytes;
    progress.Update(octomap.size());
    return octomap.size() <= kMostOctomapBytes;
  });
  if (octomap.size() > kMostOctomapBytes) {
    return absl::ResourceExhaustedError(
        absl::StrCat("the free space takes more than ", kMostOctomapBytes,
                     " bytes: give larger cells with --resolution, or a box"));
  }
  if (!read.ok()) return read.status();
  return octomap;
}

absl::Status WriteRooms(const floors::GridMap& map, const std::string& name, GridFile* file) {
  const auto found = floors::RoomsOf(map);
  if (absl::IsResourceExhausted(found.status())) return absl::OkStatus();
  if (!found.ok()) return found.status();
  file->rooms = static_cast<int64_t>(found->rooms.size());
  file->doors = static_cast<int64_t>(found->doors.size());
  return io::WriteOutput(name + "_rooms.geojson", floors::FormatRooms(*found));
}

absl::StatusOr<GridFile> WriteGrid(const floors::GridMap& map, const std::string& name) {
  const std::string image = std::filesystem::path(name).filename().string() + ".pgm";
  absl::Status status = io::WriteOutput(name + ".pgm", floors::FormatPgm(map));
  if (status.ok()) {
    status = io::WriteOutput(name + ".yaml", floors::FormatMapYaml(map, image));
  }
  if (!status.ok()) return status;
  const auto count = [&map](floors::GridCell cell) {
    return std::count(map.cells.begin(), map.cells.end(), cell);
  };
  GridFile file{name + ".yaml", map.width, map.height, count(floors::GridCell::kOccupied),
                count(floors::GridCell::kFree)};
  status = WriteRooms(map, name, &file);
  if (!status.ok()) return status;
  return file;
}

}  // namespace

absl::StatusOr<std::vector<GridFile>> WriteGrids(client::Client& client,
                                                 const GridRequest& request) {
  std::vector<floors::Floor> floors(1);
  if (!request.band) {
    const auto stations =
        exports::ReadStations(client, request.query.component, request.query.robot);
    if (!stations.ok()) return stations.status();
    floors = floors::FloorsOf(*stations);
    if (floors.empty()) {
      return absl::FailedPreconditionError(
          "no robot is in this map yet: there is no floor to draw");
    }
  }
  std::vector<GridFile> files;
  for (size_t i = 0; i < floors.size(); ++i) {
    const auto heights = request.band.value_or(floors::HeightsAround(floors[i]));
    const auto octomap = ReadOctomap(client, request.query, heights);
    if (!octomap.ok()) return octomap.status();
    if (octomap->empty()) continue;
    const auto map = floors::GridOf(*octomap, floors[i], request.band);
    if (absl::IsNotFound(map.status())) continue;
    if (!map.ok()) return map.status();
    auto file =
        WriteGrid(*map, request.band ? request.name : absl::StrCat(request.name, "_floor", i));
    if (!file.ok()) return file.status();
    file->lowest_m = request.band ? heights.lowest_m : floors[i].lowest_m;
    file->highest_m = request.band ? heights.highest_m : floors[i].highest_m;
    files.push_back(*std::move(file));
  }
  if (files.empty()) return floors::NothingThere();
  return files;
}

}  // namespace isthmus::cli
