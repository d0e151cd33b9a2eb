// The map as a file.
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/records/region_of.h"
#include "server/pipeline/view_reader.h"
#include "server/query/export.h"

namespace isthmus::server {
namespace {

// Bytes handed to a sink at a time.
constexpr size_t kFileChunk = 1 << 20;

query::CloudFormat CloudFormatOf(ExportFormat format) {
  switch (format) {
    case ExportFormat::kPcdAscii:
      return query::CloudFormat::kPcdAscii;
    case ExportFormat::kPcdBinaryCompressed:
      return query::CloudFormat::kPcdBinaryCompressed;
    case ExportFormat::kPly:
      return query::CloudFormat::kPly;
    default:
      return query::CloudFormat::kPcdBinary;
  }
}

Region WholeRegionOf(const ExportRequest& request, uint32_t component) {
  Region region = RegionOf(request, component);
  region.resolution_m = request.resolution_m;
  region.classes = PointClasses(request.classes);
  return region;
}

// The map, or what was dropped from it.
absl::StatusOr<std::shared_ptr<const ComposedMap>> PartOf(
    const std::shared_ptr<const ComposedMap>& map, const ExportRequest& request) {
  if (!request.dropped) return map;
  if (request.format == ExportFormat::kOctoMapFull ||
      request.format == ExportFormat::kOctoMapBinary) {
    return absl::InvalidArgumentError("dropped points are a cloud: export them as PCD or PLY");
  }
  if (map->dropped() != nullptr) return map->dropped();
  return absl::FailedPreconditionError(
      "nothing is dropped from this server's map: composition.drop_gone is off");
}

// In the map that the file is made of, as of the view or as composed.
absl::Status CheckRobot(const MapView& view, const RobotId& robot, uint32_t number,
                        bool is_of_view) {
  std::vector<SessionId> sessions;
  for (const auto& [id, session] : view.sessions) {
    if (!robot.empty() && session.record.robot == robot) sessions.push_back(id);
  }
  return CheckRobotIsIn(number, robot, sessions,
                        [&](const SessionId& session) -> std::optional<uint32_t> {
                          if (!is_of_view) return view.map->component_of(session);
                          const Placement* placement = view.PlacementOf(session);
                          if (placement == nullptr) return std::nullopt;
                          return placement->component;
                        });
}

}  // namespace

composition::OccupancyOptions ViewReader::OccupancyOf(const ExportRequest& request, uint32_t number,
                                                      const std::function<bool()>& keep_on) const {
  composition::OccupancyOptions occupancy = occupancy_;
  if (request.resolution_m > 0) occupancy.resolution_m = request.resolution_m;
  occupancy.region = WholeRegionOf(request, number);
  occupancy.region.keep_on = keep_on;
  occupancy.robot = request.robot;
  return occupancy;
}

absl::StatusOr<FreeSpace> ViewReader::ReadFreeSpace(const MapView& view,
                                                    const ExportRequest& wanted,
                                                    uint64_t max_file_bytes,
                                                    const std::function<bool()>& keep_on) const {
  const auto number = view.NumberOf(wanted.component);
  if (!number.ok()) return number.status();
  const auto read = [this](const SubmapId& id) { return submaps_->GetOrThrow(id); };
  return kept_occupancy_.Read(view.PlacedSubmaps(), read, *number,
                              OccupancyOf(wanted, *number, keep_on), max_file_bytes);
}

absl::Status ViewReader::ExportOccupancy(
    const MapView& view, const ExportRequest& request, uint32_t number,
    const std::function<bool(const std::string&)>& sink) const {
  const std::vector<PlacedSubmap> submaps = view.PlacedSubmaps();
  const auto format = request.format == ExportFormat::kOctoMapFull
                          ? composition::OccupancyFormat::kFull
                          : composition::OccupancyFormat::kBinary;
  const auto read = [this](const SubmapId& id) { return submaps_->GetOrThrow(id); };
  absl::StatusOr<std::string> file =
      // The evidence is cast before its first byte goes out: minutes that a reader may not wait
      // for.
      kept_occupancy_.Write(submaps, read, number, format,
                            OccupancyOf(request, number, [&sink] { return sink(""); }));
  if (!file.ok()) return file.status();
  for (size_t offset = 0; offset < file->size(); offset += kFileChunk) {
    if (!sink(file->substr(offset, kFileChunk))) {
      return absl::CancelledError("the reader went away");
    }
  }
  return absl::OkStatus();
}

absl::Status ViewReader::ExportMap(const ExportRequest& request,
                                   const std::function<void(int64_t)>& begin,
                                   const std::function<bool(const std::string&)>& sink) const {
  const MapWriter::View view = map_->view();
  if (!request.robot.empty() && view->Newest(request.robot) == nullptr) {
    return UnknownRobot(request.robot);
  }
  const bool is_occupancy = request.format == ExportFormat::kOctoMapFull ||
                            request.format == ExportFormat::kOctoMapBinary;
  std::shared_ptr<const ComposedMap> map = view->map;
  if (!is_occupancy) {
    if (absl::Status ready = map->ready(); !ready.ok()) return ready;
  }
  // Each numbers the maps in its own way until the one follows the other.
  const auto number =
      is_occupancy ? view->NumberOf(request.component) : map->NumberOf(request.component);
  if (!number.ok()) return number.status();
  if (absl::Status is_here = CheckRobot(*view, request.robot, *number, is_occupancy);
      !is_here.ok()) {
    return is_here;
  }
  const absl::StatusOr<std::shared_ptr<const ComposedMap>> wanted = PartOf(map, request);
  if (!wanted.ok()) return wanted.status();
  map = *wanted;
  if (is_occupancy) {
    // The file shows submaps where they lie by now, which the composed map follows.
    begin(view->revision->revision);
    return ExportOccupancy(*view, request, *number, sink);
  }
  Region region = WholeRegionOf(request, *number);
  if (!request.robot.empty()) {
    // A robot without points yet is number robots().size(), which no point has.
    const std::vector<RobotId>& robots = map->robots();
    region.robot =
        static_cast<int>(std::find(robots.begin(), robots.end(), request.robot) - robots.begin());
  }
  begin(map->revision());
  return query::ExportCloud(*map, region, CloudFormatOf(request.format), sink);
}

}  // namespace isthmus::server
