#include "lab/bench/changes/truth.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "lab/bench/moving/mapped_drive.h"
#include "lab/simulation/simulator.h"
#include "server/composition/composer.h"

namespace isthmus::bench {
namespace {

constexpr int kFewestPoints = 20, kFewestRays = 20, kFewestFound = 10;
constexpr double kNearM = 0.3, kAboveGroundM = 0.15;

Eigen::AlignedBox3d Grown(const Eigen::AlignedBox3d& box, double by_m) {
  return {box.min() - Eigen::Vector3d::Constant(by_m), box.max() + Eigen::Vector3d::Constant(by_m)};
}

// Half as long, wide and high.
Eigen::AlignedBox3d InnerHalf(const Eigen::AlignedBox3d& box) {
  return {box.center() - 0.25 * box.sizes(), box.center() + 0.25 * box.sizes()};
}

bool Crosses(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& from,
             const Eigen::Vector3d& to) {
  double enter = 0, leave = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double by = to[axis] - from[axis];
    double near = (box.min()[axis] - from[axis]) / by, far = (box.max()[axis] - from[axis]) / by;
    if (near > far) std::swap(near, far);
    enter = std::max(enter, near);
    leave = std::min(leave, far);
  }
  return enter < leave;
}

struct Looks {
  std::vector<std::set<std::tuple<int, int, int>>> voxels;  // One set for each moved volume.
  std::vector<int> rays;
  std::set<std::pair<int, int>> squares[2];  // One metre wide, by day.
};

void AddLooks(const Submap& submap, const Pose& T_world_submap, bool after,
              const std::vector<simulation::MovedVolume>& moved, Looks* looks) {
  for (const SubmapPoint& point : submap.points) {
    const Eigen::Vector3d at = T_world_submap * point.Position().cast<double>();
    const Eigen::Vector3d from =
        T_world_submap * submap.keyframes[point.keyframe].T_submap_sensor.translation();
    const auto index = [&](int axis, double edge_m) {
      return static_cast<int>(std::floor(at[axis] / edge_m));
    };
    looks->squares[after].insert({index(0, 1), index(1, 1)});
    for (size_t i = 0; i < moved.size(); ++i) {
      const bool there = moved[i].came == after;
      if (there && Grown(moved[i].bounds, 0.1).contains(at)) {
        looks->voxels[i].insert({index(0, 0.1), index(1, 0.1), index(2, 0.1)});
      } else if (!there && Crosses(InnerHalf(moved[i].bounds), from, at)) {
        ++looks->rays[i];
      }
    }
  }
}

// Number of points of each volume that are near each moved one; last, near none.
std::vector<std::vector<int>> FoundPoints(const TwoDays& days,
                                          const std::vector<ChangedVolume>& volumes) {
  std::vector<std::vector<int>> found(volumes.size(), std::vector<int>(days.moved.size() + 1, 0));
  for (size_t v = 0; v < volumes.size(); ++v) {
    for (const Eigen::Vector3f& place : volumes[v].places) {
      bool near_any = false;
      for (size_t i = 0; i < days.moved.size(); ++i) {
        if (days.moved[i].came != volumes[v].came) continue;
        if (!Grown(days.moved[i].bounds, kNearM).contains(place.cast<double>())) continue;
        ++found[v][i];
        near_any = true;
      }
      if (!near_any) ++found[v].back();
    }
  }
  return found;
}

void Print(const char* what, bool came, const Eigen::Vector3d& middle, const Eigen::Vector3d& size,
           const std::string& more) {
  absl::PrintF("%s %s: %.1f %.1f %.1f, %.1f x %.1f x %.1f, %s\n", what, came ? "came" : "went",
               middle.x(), middle.y(), middle.z(), size.x(), size.y(), size.z(), more);
}

}  // namespace

absl::StatusOr<std::vector<simulation::MovedVolume>> MovedOf(const DriveOptions& drive) {
  auto simulator = simulation::Simulator::Create({.world = drive.world,
                                                  .robots = drive.robots,
                                                  .seconds = drive.seconds,
                                                  .seed = drive.seed,
                                                  .day = drive.day,
                                                  .moved = drive.moved});
  if (!simulator.ok()) return simulator.status();
  return (*simulator)->moved();
}

Verdict Compare(const TwoDays& days, const std::vector<ChangedVolume>& volumes, bool list) {
  Looks looks;
  looks.voxels.resize(days.moved.size());
  looks.rays.resize(days.moved.size());
  for (size_t i = 0; i < days.submaps.size(); ++i) {
    AddLooks(*days.content.at(days.submaps[i].placed.submap->id), days.T_world_submap[i],
             days.submaps[i].is_after, days.moved, &looks);
  }
  Verdict verdict;
  for (const auto& square : looks.squares[0]) verdict.seen_m2 += looks.squares[1].count(square);
  const auto points = FoundPoints(days, volumes);
  for (size_t i = 0; i < days.moved.size(); ++i) {
    const int seen = static_cast<int>(looks.voxels[i].size());
    if (seen < kFewestPoints || looks.rays[i] < kFewestRays) continue;
    ++verdict.knowable;
    int near = 0;
    for (const auto& of_volume : points) near += of_volume[i];
    if (near >= kFewestFound) {
      ++verdict.found;
    } else if (list) {
      const auto& box = days.moved[i].bounds;
      Print("missed", days.moved[i].came, box.center(), box.sizes(),
            absl::StrFormat("%d voxels, %d rays", seen, looks.rays[i]));
    }
  }
  for (size_t v = 0; v < volumes.size(); ++v) {
    if (2 * static_cast<size_t>(points[v].back()) <= volumes[v].places.size()) continue;
    ++verdict.wrong;
    if (list) {
      Print("wrong", volumes[v].came, volumes[v].T_map_box.translation(), volumes[v].size,
            absl::StrFormat(
                "%d points, %.4f, %.1f s", volumes[v].points, volumes[v].probability,
                1e-9 * static_cast<double>(volumes[v].seen_last_ns - volumes[v].seen_first_ns)));
    }
  }
  return verdict;
}

absl::StatusOr<CameCounts> CountDropped(const TwoDays& days) {
  std::vector<PlacedSubmap> placed;
  for (const composition::ComparedSubmap& submap : days.submaps) placed.push_back(submap.placed);
  composition::Composer composer({.cache_bytes = size_t{4} << 30, .drop_gone = true});
  const auto map = composer.Compose(1, placed, [&](const auto& id) { return days.content.at(id); });
  if (!map.ok()) return map.status();
  std::vector<Eigen::AlignedBox3d> came;
  for (const simulation::MovedVolume& moved : days.moved) {
    if (moved.came) came.push_back(Grown(moved.bounds, 0.1));
  }
  const auto count = [&](const ComposedMap& from, int64_t* number) {
    return from.Read({}, 10000, [&](const std::vector<MapPoint>& points) {
      *number += std::ranges::count_if(points, [&](const MapPoint& p) {
        const Eigen::Vector3d at(p.x, p.y, p.z);
        return p.z > kAboveGroundM && p.intensity < kMovingIntensity &&
               std::ranges::any_of(came, [&](const auto& box) { return box.contains(at); });
      });
      return true;
    });
  };
  CameCounts counts;
  absl::Status status = count(*(*map)->dropped(), &counts.dropped);
  counts.all = counts.dropped;
  if (status.ok()) status = count(**map, &counts.all);
  if (!status.ok()) return status;
  return counts;
}

}  // namespace isthmus::bench
