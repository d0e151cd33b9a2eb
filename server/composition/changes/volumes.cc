#include "server/composition/changes/volumes.h"

#include <absl/container/flat_hash_map.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <span>
#include <utility>

#include "core/union_find.h"
#include "server/composition/changes/limits.h"
#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {
namespace {

using Cluster = std::vector<const ChangedPoint*>;

// Clusters of the points whose kind is `came`, in order of their first points.
std::vector<Cluster> Connect(const std::vector<ChangedPoint>& points, bool came) {
  absl::flat_hash_map<uint64_t, size_t> cells;
  std::vector<Voxel> voxels;
  const auto cell_of = [](const ChangedPoint& p) {
    const Eigen::Vector3f v =
        p.at.cwiseQuotient(Eigen::Vector3f(kGapM, kGapM, kGapUpM)).array().floor();
    return Voxel{static_cast<int32_t>(v.x()), static_cast<int32_t>(v.y()),
                 static_cast<int32_t>(v.z())};
  };
  for (const ChangedPoint& p : points) {
    if (p.came != came) continue;
    const Voxel voxel = cell_of(p);
    if (cells.try_emplace(PackVoxel(voxel), voxels.size()).second) voxels.push_back(voxel);
  }
  UnionFind sets(voxels.size());
  for (size_t i = 0; i < voxels.size(); ++i) {
    for (int k = 0; k < 27; ++k) {
      const Voxel v{voxels[i].x + k % 3 - 1, voxels[i].y + k / 3 % 3 - 1, voxels[i].z + k / 9 - 1};
      if (const auto it = cells.find(PackVoxel(v)); it != cells.end()) sets.Unite(i, it->second);
    }
  }
  std::map<size_t, size_t> numbers;
  std::vector<Cluster> clusters;
  for (const ChangedPoint& p : points) {
    if (p.came != came) continue;
    const size_t set = sets.Find(cells.at(PackVoxel(cell_of(p))));
    const auto [it, is_new] = numbers.try_emplace(set, clusters.size());
    if (is_new) clusters.emplace_back();
    clusters[it->second].push_back(&p);
  }
  return clusters;
}

bool IsSteady(const Cluster& cluster) {
  const auto steady = std::ranges::count_if(cluster, [](const ChangedPoint* p) {
    return 1e-9 * static_cast<double>(p->last_ns - p->first_ns) >= kSteadyS;
  });
  return 2 * static_cast<size_t>(steady) >= cluster.size();
}

bool IsDriftedSheet(const Cluster& cluster) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const ChangedPoint* p : cluster) mean += p->at.cast<double>();
  mean /= static_cast<double>(cluster.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const ChangedPoint* p : cluster) {
    const Eigen::Vector3d d = p->at.cast<double>() - mean;
    spread += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  const double off_plane = std::sqrt(axes.eigenvalues()[0] / static_cast<double>(cluster.size()));
  if (off_plane > kSheetM) return false;
  const Eigen::Vector3f normal = axes.eigenvectors().col(0).cast<float>();
  const auto beside = std::ranges::count_if(cluster, [&](const ChangedPoint* p) {
    return p->to_other.allFinite() &&
           std::abs(p->to_other.dot(normal)) > kAlongNormal * p->to_other.norm();
  });
  return 2 * static_cast<size_t>(beside) > cluster.size();
}

// Rays of the other side go through it, not along it.
bool IsPassedThrough(const Cluster& cluster) {
  const auto through = std::ranges::count_if(
      cluster, [](const ChangedPoint* p) { return p->passes_behind >= kFewestPasses; });
  return static_cast<double>(through) >= kPassedShare * static_cast<double>(cluster.size());
}

// The upright box of least area seen from above, to two degrees.
void FitBox(const Cluster& cluster, ChangedVolume* volume) {
  constexpr int kTurns = 45;
  double best_area = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kTurns; ++i) {
    const double yaw = i * std::numbers::pi / (2 * kTurns);
    const Pose T_map_turned = Pose::FromXyzRpy(0, 0, 0, 0, 0, yaw);
    const Pose T_turned_map = T_map_turned.Inverse();
    Box box;
    for (const ChangedPoint* p : cluster) box.Extend(T_turned_map * p->at.cast<double>());
    const Eigen::Vector3d size =
        box.max - box.min + Eigen::Vector3d::Constant(kComparedVoxelM);  // Whole voxels.
    const double area = size.x() * size.y();
    if (area >= best_area) continue;
    best_area = area;
    const bool turn = size.y() > size.x();
    volume->size = turn ? Eigen::Vector3d(size.y(), size.x(), size.z()) : size;
    volume->T_map_box =
        Pose(Pose::FromXyzRpy(0, 0, 0, 0, 0, yaw + (turn ? std::numbers::pi / 2 : 0)).rotation(),
             T_map_turned * Eigen::Vector3d(0.5 * (box.min + box.max)));
  }
}

void AddTimesAndRobots(const Cluster& cluster, const std::vector<ComparedSubmap>& submaps,
                       ChangedVolume* volume) {
  volume->seen_first_ns = std::numeric_limits<int64_t>::max();
  volume->missing_ns = cluster.front()->missing_ns;
  std::set<RobotId> seen_by, missed_by;
  for (const ChangedPoint* p : cluster) {
    volume->seen_first_ns = std::min(volume->seen_first_ns, p->first_ns);
    volume->seen_last_ns = std::max(volume->seen_last_ns, p->last_ns);
    volume->missing_ns = volume->came ? std::max(volume->missing_ns, p->missing_ns)
                                      : std::min(volume->missing_ns, p->missing_ns);
    seen_by.insert(submaps[p->seen_by].placed.submap->robot);
    missed_by.insert(submaps[p->missed_by].placed.submap->robot);
    const auto passes = static_cast<double>(std::min<uint32_t>(p->passes, kMostPasses));
    volume->probability += 1 / (1 + std::pow(kPassOdds, passes));
  }
  volume->probability /= static_cast<double>(cluster.size());
  volume->seen_by.assign(seen_by.begin(), seen_by.end());
  volume->missed_by.assign(missed_by.begin(), missed_by.end());
}

std::vector<Eigen::Vector3f> PlacesOf(const Cluster& cluster) {
  std::vector<Eigen::Vector3f> places;
  const size_t step = (cluster.size() + kMostPlaces - 1) / kMostPlaces;
  for (size_t i = 0; i < cluster.size(); i += step) places.push_back(cluster[i]->at);
  return places;
}

}  // namespace

std::vector<ChangedVolume> MakeVolumes(const std::vector<ChangedPoint>& points,
                                       const std::vector<ComparedSubmap>& submaps,
                                       const VolumeOptions& options) {
  std::vector<ChangedVolume> volumes;
  for (const bool came : {false, true}) {
    for (const Cluster& cluster : Connect(points, came)) {
      if (cluster.size() < kFewestPoints || !IsSteady(cluster) || !IsPassedThrough(cluster) ||
          IsDriftedSheet(cluster)) {
        continue;
      }
      ChangedVolume volume;
      volume.came = came;
      volume.points = cluster.size();
      FitBox(cluster, &volume);
      if (volume.size.maxCoeff() < options.smallest_m) continue;
      AddTimesAndRobots(cluster, submaps, &volume);
      if (options.wants_points) volume.places = PlacesOf(cluster);
      volumes.push_back(std::move(volume));
    }
  }
  std::ranges::stable_sort(volumes, [](const ChangedVolume& a, const ChangedVolume& b) {
    return a.size.prod() > b.size.prod();
  });
  return volumes;
}

}  // namespace isthmus::composition
