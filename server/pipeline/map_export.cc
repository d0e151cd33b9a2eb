// The map as a file.
#include <absl/strings/str_cat.h>

#include <utility>

#include "server/pipeline/map_reader.h"
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

}  // namespace

absl::Status MapReader::ExportOccupancy(composition::OccupancyFormat format, const Region& region,
                                        double resolution_m,
                                        const std::function<bool(const std::string&)>& sink) const {
  composition::OccupancyOptions occupancy = occupancy_;
  if (resolution_m > 0) occupancy.resolution_m = resolution_m;
  absl::StatusOr<std::string> file = composition::WriteOccupancy(
      map_->view()->PlacedSubmaps(), [this](const SubmapId& id) { return submaps_->Get(id); },
      region.component, format, occupancy);
  if (!file.ok()) return file.status();
  for (size_t offset = 0; offset < file->size(); offset += kFileChunk) {
    if (!sink(file->substr(offset, kFileChunk))) {
      return absl::CancelledError("the reader went away");
    }
  }
  return absl::OkStatus();
}

absl::Status MapReader::ExportMap(ExportFormat format, const Region& region,
                                  double octomap_resolution_m,
                                  const std::function<bool(const std::string&)>& sink) const {
  if (format == ExportFormat::kOctoMapFull || format == ExportFormat::kOctoMapBinary) {
    const auto as = format == ExportFormat::kOctoMapFull ? composition::OccupancyFormat::kFull
                                                         : composition::OccupancyFormat::kBinary;
    return ExportOccupancy(as, region, octomap_resolution_m, sink);
  }
  const std::shared_ptr<const ComposedMap> map = GetMap();
  if (region.component != 0 && region.component >= map->component_count()) {
    return absl::NotFoundError(
        absl::StrCat("no component ", region.component, ": the map has ", map->component_count()));
  }
  return query::ExportCloud(*map, region, CloudFormatOf(format), sink);
}

}  // namespace isthmus::server
