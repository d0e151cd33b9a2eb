#include "server/composition/occupancy.h"

#include <absl/strings/str_cat.h>
#include <octomap/OcTree.h>

#include <cmath>
#include <exception>
#include <sstream>

#include "server/composition/limits.h"
#include "server/composition/occupancy_grid.h"

namespace isthmus::composition {
namespace {

// OctoMap numbers voxels with so many bits per axis, the origin in the middle.
constexpr int32_t OctreeReach() { return 1 << (8 * sizeof(octomap::key_type) - 1); }

absl::Status CheckOptions(const OccupancyOptions& options) {
  const double resolution = options.resolution_m, range = options.max_range_m;
  if (!(resolution >= 0.01 && resolution <= 10)) {
    return absl::InvalidArgumentError(
        absl::StrCat("OctoMap resolution is ", resolution, " m; give 0.01 to 10 m"));
  }
  if (!(range >= resolution && range <= 1000)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "OctoMap range is ", range, " m; give at least the resolution and at most 1000 m"));
  }
  return absl::OkStatus();
}

absl::Status CheckReach(const Eigen::Vector3d& origin, const OccupancyOptions& options) {
  const double reach = OctreeReach() * options.resolution_m;
  const double needed = origin.cwiseAbs().maxCoeff() + options.max_range_m + options.resolution_m;
  if (needed < reach) return absl::OkStatus();
  return absl::OutOfRangeError(absl::StrCat("The map reaches ", std::ceil(needed),
                                            " m from its origin, an OctoMap of ",
                                            options.resolution_m, " m voxels ends at ",
                                            std::floor(reach), " m: choose a coarser resolution"));
}

absl::Status TooLarge(const OccupancyOptions& options) {
  return absl::ResourceExhaustedError(
      absl::StrCat("An OctoMap of ", options.resolution_m, " m voxels and ", options.max_range_m,
                   " m range needs more than ", options.max_bytes >> 20,
                   " MB here: choose a coarser resolution, a shorter "
                   "range or fewer robots"));
}

absl::Status InsertSubmap(const Submap& submap, const Pose& T_map_submap,
                          const OccupancyOptions& options, OccupancyGrid* grid) {
  const Eigen::Matrix3d R = T_map_submap.RotationMatrix();
  std::vector<Eigen::Vector3d> points;
  size_t begin = 0;
  for (size_t k = 0; k < submap.keyframes.size(); ++k) {
    const Eigen::Vector3d origin = T_map_submap * submap.keyframes[k].T_submap_sensor.translation();
    points.clear();
    // Points are grouped by keyframe.
    for (; begin < submap.points.size() && submap.points[begin].keyframe <= k; ++begin) {
      const SubmapPoint& p = submap.points[begin];
      points.push_back(R * p.Position().cast<double>() + T_map_submap.translation());
    }
    if (!origin.allFinite()) continue;
    if (const absl::Status status = CheckReach(origin, options); !status.ok()) return status;
    const bool fits = grid->InsertScan(origin, points) &&
                      grid->bytes() + grid->known_voxels() * kBytesPerLeaf <= options.max_bytes;
    if (!fits) return TooLarge(options);
  }
  return absl::OkStatus();
}

// OcTree::writeBinary with its header spelled out: the library's own prints to stderr as it goes.
// The first line is what readers know the format by.
void WriteBinary(const octomap::OcTree& tree, std::ostream& file) {
  file << "# Octomap OcTree binary file\nid " << tree.getTreeType() << "\nsize " << tree.size()
       << "\nres " << tree.getResolution() << "\ndata\n";
  tree.writeBinaryData(file);
}

std::string Serialize(const OccupancyGrid& grid, OccupancyFormat format,
                      const OccupancyOptions& options) {
  octomap::OcTree tree(options.resolution_m);
  grid.ForEachKnown([&](int32_t x, int32_t y, int32_t z, float log_odds) {
    const auto key = [](int32_t i) { return static_cast<octomap::key_type>(i + OctreeReach()); };
    // Lazy: inner nodes are summed up once, at the end.
    tree.setNodeValue(octomap::OcTreeKey(key(x), key(y), key(z)), log_odds, true);
  });
  tree.updateInnerOccupancy();
  if (format == OccupancyFormat::kBinary) tree.toMaxLikelihood();
  tree.prune();
  std::ostringstream file;
  if (format == OccupancyFormat::kBinary) {
    WriteBinary(tree, file);
  } else {
    tree.write(file);
  }
  return std::move(file).str();
}

SensorEvidence OctomapEvidence(double resolution_m) {
  const octomap::OcTree tree(resolution_m);
  return {tree.getProbHitLog(), tree.getProbMissLog(), tree.getClampingThresMinLog(),
          tree.getClampingThresMaxLog()};
}

absl::StatusOr<std::string> Build(const std::vector<PlacedSubmap>& submaps,
                                  const SubmapReader& reader, uint32_t component,
                                  OccupancyFormat format, const OccupancyOptions& options,
                                  uint64_t* missing) {
  OccupancyGrid grid(options.resolution_m, options.max_range_m, options.max_bytes,
                     OctomapEvidence(options.resolution_m), options.region);
  for (const PlacedSubmap& placed : submaps) {
    if (!placed.submap || placed.component != component) continue;
    const std::shared_ptr<const Submap> submap = reader(placed.submap->id);
    if (submap == nullptr) {
      ++*missing;
      continue;
    }
    const absl::Status status = InsertSubmap(*submap, placed.T_map_submap, options, &grid);
    if (!status.ok()) return status;
  }
  return Serialize(grid, format, options);
}

}  // namespace

absl::StatusOr<std::string> WriteOccupancy(const std::vector<PlacedSubmap>& submaps,
                                           const SubmapReader& reader, uint32_t component,
                                           OccupancyFormat format, const OccupancyOptions& options,
                                           uint64_t* missing) {
  uint64_t missing_here = 0;
  if (missing == nullptr) missing = &missing_here;
  *missing = 0;
  if (const absl::Status status = CheckOptions(options); !status.ok()) return status;
  try {
    return Build(submaps, reader, component, format, options, missing);
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(
        "No memory left for the OctoMap: choose a coarser resolution or a shorter range");
  } catch (const std::exception& e) {
    return absl::InternalError(absl::StrCat("OctoMap failed: ", e.what()));
  }
}

}  // namespace isthmus::composition
