#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <utility>
#include <vector>

#include "client/exports/cloud_files.h"
#include "core/formats/autoware.h"
#include "core/formats/map_writer.h"
#include "core/io/append_file.h"
#include "core/io/folder.h"
#include "core/io/part_file.h"

namespace isthmus::exports {
namespace {

namespace fs = std::filesystem;

constexpr auto kTileEncoding = formats::PcdEncoding::kBinary;  // Format

using formats::CellCorner;

// Points wait in memory, then in a file per tile without a header, as its length is not known.
class TileSet {
 public:
  TileSet(std::string folder, int64_t tile_m) : folder_(std::move(folder)), tile_m_(tile_m) {}

  absl::Status Add(const std::vector<MapPoint>& points) {
    for (const MapPoint& point : points) {
      tiles_[{CornerOf(point.x), CornerOf(point.y)}].held.push_back(point);
    }
    held_bytes_ += points.size() * sizeof(MapPoint);
    return held_bytes_ < kTileBytesHeld ? absl::OkStatus() : Flush();
  }

  // Gives every tile its header, and lists them.
  absl::StatusOr<std::string> Finish(const std::vector<RobotId>& robots) {
    if (absl::Status status = Flush(); !status.ok()) return status;
    std::vector<CellCorner> corners;
    for (const auto& [corner, tile] : tiles_) {
      const std::string waiting = WaitingName(corner);
      const auto body = io::ReadFile(waiting);
      if (!body.ok()) return body.status();
      const absl::Status written =
          io::ReplaceFile(absl::StrCat(folder_, "/", formats::CellFileName(corner)),
                          formats::PcdMapHeader(tile.count, kTileEncoding, robots) + *body);
      if (!written.ok()) return written;
      std::error_code none;
      fs::remove(waiting, none);
      corners.push_back(corner);
    }
    return formats::FormatCellList(tile_m_, corners);
  }
  uint64_t size() const { return tiles_.size(); }

 private:
  struct Tile {
    std::vector<MapPoint> held;
    uint64_t count = 0;  // Written.
  };

  int64_t CornerOf(float at) const {
    return static_cast<int64_t>(std::floor(at / static_cast<double>(tile_m_))) * tile_m_;
  }
  std::string WaitingName(const CellCorner& corner) const {
    return absl::StrCat(folder_, "/", formats::CellFileName(corner), ".points");
  }

  absl::Status Flush() {
    for (auto& [corner, tile] : tiles_) {
      if (tile.held.empty()) continue;
      const auto file = io::AppendFile::Open(WaitingName(corner));
      if (!file.ok()) return file.status();
      const absl::Status status = (*file)->Append(formats::PcdMapChunk(tile.held, kTileEncoding));
      if (!status.ok()) return status;
      tile.count += std::exchange(tile.held, {}).size();
    }
    held_bytes_ = 0;
    return absl::OkStatus();
  }

  const std::string folder_;
  const int64_t tile_m_;
  std::map<CellCorner, Tile> tiles_;
  size_t held_bytes_ = 0;
};

absl::Status CheckTarget(const std::string& folder, double tile_m) {
  if (!(tile_m >= 1) || tile_m > 1e6 || tile_m != std::floor(tile_m)) {
    return absl::InvalidArgumentError(
        absl::StrCat("tiles of ", tile_m, " m: give a whole number of metres, at least 1"));
  }
  if (!fs::exists(folder)) return absl::OkStatus();
  return absl::AlreadyExistsError(
      absl::StrCat(folder, " exists already: give a new folder, or remove it first"));
}

// Only where Autoware can say it: its local Cartesian frame is not turned.
absl::Status WriteProjector(const std::string& folder, const std::optional<earth::Site>& site) {
  if (!site || site->datum().heading_deg != 0) return absl::OkStatus();
  const Datum& datum = site->datum();
  return io::ReplaceFile(
      absl::StrCat(folder, "/map_projector_info.yaml"),
      absl::StrFormat("projector_type: LocalCartesian\nvertical_datum: WGS84\nmap_origin:\n"
                      "  latitude: %.10f\n  longitude: %.10f\n  altitude: %.4f\n",
                      datum.latitude_deg, datum.longitude_deg, datum.altitude_m));
}

}  // namespace

absl::StatusOr<CloudSummary> WriteTiles(client::Client& client, const RegionQuery& query,
                                        const std::optional<earth::Site>& site, double tile_m,
                                        const std::string& folder, const CloudProgress& progress) {
  if (absl::Status status = CheckTarget(folder, tile_m); !status.ok()) return status;
  const std::string part = folder + ".part", clouds = part + "/pointcloud_map";
  std::error_code none;
  fs::remove_all(part, none);  // Left by a run that was killed.
  io::PartFolder target(part);
  if (absl::Status status = io::MakeFolder(clouds); !status.ok()) return status;
  TileSet tiles(clouds, static_cast<int64_t>(tile_m));
  CloudSummary summary;
  std::vector<RobotId> robots;
  absl::Status failure;
  const absl::Status read = client.QueryRegion(query, [&](const RegionChunk& chunk) {
    summary.revision = chunk.revision;
    summary.points += chunk.points.size();
    robots = chunk.robots;
    failure = tiles.Add(chunk.points);
    if (progress) progress(summary.points);
    return failure.ok();
  });
  if (!failure.ok()) return failure;
  if (!read.ok()) return read;
  // Autoware's map loader takes no map without cells.
  if (summary.points == 0) return absl::NotFoundError("that part holds nothing of the map");
  const auto yaml = tiles.Finish(robots);
  if (!yaml.ok()) return yaml.status();
  absl::Status status = io::ReplaceFile(part + "/pointcloud_map_metadata.yaml", *yaml);
  if (status.ok()) status = WriteProjector(part, site);
  if (status.ok()) status = target.Become(folder);
  if (!status.ok()) return status;
  summary.files = tiles.size();
  return summary;
}

}  // namespace isthmus::exports
