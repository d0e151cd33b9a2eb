#include "server/composition/occupancy/kept_occupancy.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "core/records/map_reading.h"
#include "server/composition/occupancy/layer_update.h"
#include "server/composition/occupancy/limits.h"
#include "server/composition/occupancy/region_cut.h"

namespace isthmus::composition {
namespace {

absl::Status CheckOptions(const OccupancyOptions& options) {
  const double resolution = options.resolution_m, range = options.max_range_m;
  if (!(resolution >= kLeastLeafM && resolution <= kMostLeafM)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "OctoMap resolution is ", resolution, " m; give ", kLeastLeafM, " to ", kMostLeafM, " m"));
  }
  if (!(range >= resolution && range <= 1000)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "OctoMap range is ", range, " m; give at least the resolution and at most 1000 m"));
  }
  return absl::OkStatus();
}

// Columns in the region; `taken` gets the memory that they and the layer take.
std::vector<PlacedColumn> ColumnsIn(const EvidenceLayer& layer, const OccupancyOptions& options,
                                    uint64_t* taken) {
  const RegionCut cut(options.region, options.resolution_m);
  std::vector<PlacedColumn> columns;
  for (const auto& [key, column] : layer.columns) {
    *taken += column.packed->bytes();
    if (!cut.MayTouch(key)) continue;
    PlacedColumn placed{key, cut.Cut(key, column.packed)};
    if (placed.column != column.packed) *taken += placed.column->bytes();
    columns.push_back(std::move(placed));
  }
  return columns;
}

// As many of the columns as there is room for.
void KeepTo(uint64_t max_bytes, EvidenceLayer* layer) {
  uint64_t bytes = layer->bytes();
  for (auto it = layer->columns.begin(); bytes > max_bytes && it != layer->columns.end();) {
    bytes -= std::min(bytes, it->second.packed->bytes());
    layer->columns.erase(it++);
  }
}

}  // namespace

KeptOccupancy::Layer KeptOccupancy::Find(const std::vector<const PlacedSubmap*>& submaps,
                                         const OccupancyOptions& options) const {
  std::list<Layer> layers;
  {
    const MutexLock lock(&mutex_);
    layers = layers_;
  }
  Layer best;
  size_t most = 0;
  for (const Layer& layer : layers) {
    if (layer->resolution_m != options.resolution_m || layer->max_range_m != options.max_range_m ||
        layer->robot != options.robot) {
      continue;
    }
    size_t shared = 0;
    for (const PlacedSubmap* placed : submaps) {
      const auto it = layer->submaps.find(placed->submap->id);
      shared += it != layer->submaps.end() && it->second.stamp == IdentityOf(*placed);
    }
    if (shared > most) best = layer;
    most = std::max(most, shared);
  }
  return best;
}

void KeptOccupancy::Keep(const Layer& before, EvidenceLayer layer) {
  KeepTo(max_kept_bytes_, &layer);
  if (layer.columns.empty()) return;
  auto kept = std::make_shared<const EvidenceLayer>(std::move(layer));
  const MutexLock lock(&mutex_);
  layers_.remove(before);
  layers_.push_front(std::move(kept));
  uint64_t bytes = 0;
  size_t count = 0;
  std::erase_if(layers_, [&](const Layer& each) {
    bytes += each->bytes();
    return ++count > kKeptLayers || bytes > max_kept_bytes_;
  });
}

uint64_t KeptOccupancy::kept_bytes() const {
  const MutexLock lock(&mutex_);
  uint64_t bytes = 0;
  for (const Layer& layer : layers_) bytes += layer->bytes();
  return bytes;
}

template <typename Made>
absl::StatusOr<Made> KeptOccupancy::Make(
    const std::vector<PlacedSubmap>& submaps, const SubmapReader& reader, uint32_t component,
    const OccupancyOptions& options, Cost* cost,
    const std::function<absl::StatusOr<Made>(const Columns& columns, uint64_t bytes)>& make) {
  if (absl::Status status = CheckOptions(options); !status.ok()) return status;
  try {
    std::vector<const PlacedSubmap*> wanted;
    for (const PlacedSubmap& placed : submaps) {
      if (placed.submap == nullptr || placed.component != component) continue;
      if (options.robot.empty() || placed.submap->robot == options.robot) wanted.push_back(&placed);
    }
    const Layer before = Find(wanted, options);
    auto updated = UpdateLayer(before.get(), wanted, reader, options);
    if (!updated.ok()) return updated.status();
    if (cost != nullptr) *cost = {updated->missing, updated->columns_cast};
    uint64_t taken = 0;
    const Columns columns = ColumnsIn(updated->layer, options, &taken);
    absl::StatusOr<Made> made = TooLargeOctomap(options);
    if (taken < options.max_bytes) made = make(columns, options.max_bytes - taken);
    Keep(before, std::move(updated->layer));
    return made;
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(
        "No memory left for the OctoMap: choose a coarser resolution or a shorter range");
  } catch (const std::exception& e) {
    return absl::InternalError(absl::StrCat("OctoMap failed: ", e.what()));
  }
}

absl::StatusOr<std::string> KeptOccupancy::Write(const std::vector<PlacedSubmap>& submaps,
                                                 const SubmapReader& reader, uint32_t component,
                                                 OccupancyFormat format,
                                                 const OccupancyOptions& options, Cost* cost) {
  return Make<std::string>(
      submaps, reader, component, options, cost,
      [&](const Columns& columns, uint64_t bytes) -> absl::StatusOr<std::string> {
        auto file = FormatOctomap(columns, format, options.resolution_m, bytes);
        if (absl::IsResourceExhausted(file.status())) return TooLargeOctomap(options);
        return file;
      });
}

absl::StatusOr<FreeSpace> KeptOccupancy::Read(const std::vector<PlacedSubmap>& submaps,
                                              const SubmapReader& reader, uint32_t component,
                                              const OccupancyOptions& options,
                                              uint64_t max_file_bytes) {
  return Make<FreeSpace>(submaps, reader, component, options, nullptr,
                         [&](const Columns& columns, uint64_t bytes) -> absl::StatusOr<FreeSpace> {
                           auto cubes = OctomapCubes(columns, std::min(bytes, max_file_bytes));
                           if (!cubes.ok()) return cubes.status();
                           return FreeSpace{options.resolution_m, *std::move(cubes)};
                         });
}

absl::StatusOr<std::string> WriteOccupancy(const std::vector<PlacedSubmap>& submaps,
                                           const SubmapReader& reader, uint32_t component,
                                           OccupancyFormat format, const OccupancyOptions& options,
                                           uint64_t* missing) {
  KeptOccupancy::Cost cost;
  auto file = KeptOccupancy(0).Write(submaps, reader, component, format, options, &cost);
  if (missing != nullptr) *missing = cost.missing;
  return file;
}

}  // namespace isthmus::composition
