#include "lab/bench/classes/labelled_drive.h"

#include <absl/container/flat_hash_map.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "lab/bench/moving/mapped_drive.h"
#include "server/composition/thinned_submap.h"

namespace isthmus::bench {
namespace {

constexpr double kVoxelM = 0.1;
using Votes = std::array<uint32_t, kPointClasses>;

// Intensity is the class.
LabelledSubmap Label(const Submap& submap) {
  const composition::VoxelGrid grid(kVoxelM);
  composition::VoxelThinner thinner;
  const auto thinned = composition::Thin(submap, grid, &thinner, [] { return true; });
  absl::flat_hash_map<uint64_t, Votes> votes;
  for (const SubmapPoint& p : submap.points) {
    const auto voxel = grid.Find(p.x, p.y, p.z);
    const auto of = static_cast<size_t>(std::lround(p.intensity));
    if (voxel && of < kPointClasses) ++votes[composition::PackVoxel(*voxel)][of];
  }
  LabelledSubmap labelled;
  for (const composition::WeightedPoint& p : thinned->points) {
    const auto voxel = grid.Find(p.x, p.y, p.z);
    const auto it = voxel ? votes.find(composition::PackVoxel(*voxel)) : votes.end();
    if (it == votes.end()) continue;  // Its mean was rounded out of the voxel.
    const auto most = std::max_element(it->second.begin(), it->second.end());
    labelled.points.emplace_back(p.x, p.y, p.z);
    labelled.truth.push_back(static_cast<PointClass>(most - it->second.begin()));
  }
  for (const Keyframe& keyframe : submap.keyframes) {
    labelled.sensors.push_back(keyframe.T_submap_sensor.translation().cast<float>());
  }
  labelled.up =
      (submap.T_odom_submap.rotation().inverse() * Eigen::Vector3d::UnitZ()).cast<float>();
  return labelled;
}

}  // namespace

absl::StatusOr<std::vector<LabelledSubmap>> LabelledDrives(DriveOptions options) {
  options.truth = simulation::Truth::kClass;
  const auto team = MapTeam(options);
  if (!team.ok()) return team.status();
  std::vector<LabelledSubmap> all;
  for (const auto& [id, submap] : team->content) all.push_back(Label(*submap));
  return all;
}

}  // namespace isthmus::bench
