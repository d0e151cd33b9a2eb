#include "bench/merging/seen_surface.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace isthmus::bench {
namespace {

constexpr uint64_t kStride = 10;  // Scans, when looking for the last.

uint64_t CellOf(const Eigen::Vector3d& point, double cell_m) {
  uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cell = static_cast<int64_t>(std::floor(point[axis] / cell_m));
    key = (key << 21) | (static_cast<uint64_t>(cell) & 0x1FFFFF);
  }
  return key;
}

const ScanPose* FindPose(const DrivenRobot& robot, uint64_t sequence) {
  const auto it = std::lower_bound(
      robot.poses.begin(), robot.poses.end(), sequence,
      [](const ScanPose& pose, uint64_t wanted) { return pose.sequence < wanted; });
  return it == robot.poses.end() || it->sequence != sequence ? nullptr : &*it;
}

}  // namespace

SeenSurface::SeenSurface(const DrivenRobot& robot) {
  for (const auto& submap : robot.submaps) {
    std::vector<Pose> T_world_submap;  // By keyframe.
    for (const Keyframe& keyframe : submap->keyframes) {
      const ScanPose* pose = FindPose(robot, keyframe.sequence);
      T_world_submap.push_back(
          pose == nullptr ? Pose() : pose->T_world_sensor * keyframe.T_submap_sensor.Inverse());
    }
    for (const SubmapPoint& point : submap->points) {
      const Eigen::Vector3d at =
          T_world_submap[point.keyframe] * point.Position().cast<double>().eval();
      const uint64_t sequence = submap->keyframes[point.keyframe].sequence;
      const auto [it, is_new] = first_seen_.try_emplace(CellOf(at, robot.overlap_cell_m), sequence);
      if (!is_new) it->second = std::min(it->second, sequence);
    }
  }
}

double SeenSurface::Overlap(const SeenSurface& a, const SeenSurface& b, uint64_t sequence) {
  size_t cells_a = 0, cells_b = 0, common = 0;
  for (const auto& [cell, first] : b.first_seen_) cells_b += first <= sequence ? 1 : 0;
  for (const auto& [cell, first] : a.first_seen_) {
    if (first > sequence) continue;
    ++cells_a;
    const auto it = b.first_seen_.find(cell);
    if (it != b.first_seen_.end() && it->second <= sequence) ++common;
  }
  const size_t least = std::min(cells_a, cells_b);
  return least == 0 ? 0 : static_cast<double>(common) / static_cast<double>(least);
}

std::optional<uint64_t> FindStop(const DrivenRobot& a, const DrivenRobot& b,
                                 const OverlapRange& range) {
  const SeenSurface seen_a(a), seen_b(b);
  const uint64_t last = std::max(a.poses.back().sequence, b.poses.back().sequence);
  for (uint64_t stop = last; stop > kStride; stop -= kStride) {
    const double overlap = SeenSurface::Overlap(seen_a, seen_b, stop);
    if (overlap >= range.least && overlap <= range.most) return stop;
  }
  return std::nullopt;
}

void StopAfter(uint64_t sequence, DrivenRobot* robot) {
  std::erase_if(robot->submaps, [&](const auto& submap) {
    return submap->id.index > 0 && submap->keyframes.front().sequence > sequence;
  });
  std::erase_if(robot->poses, [&](const ScanPose& pose) {
    return pose.sequence > std::max(sequence, robot->submaps[0]->keyframes[0].sequence);
  });
  auto last = std::make_shared<Submap>(*robot->submaps.back());
  size_t kept = 1;
  while (kept < last->keyframes.size() && last->keyframes[kept].sequence <= sequence) ++kept;
  last->keyframes.resize(kept);
  std::erase_if(last->points, [&](const SubmapPoint& p) { return p.keyframe >= kept; });
  last->last_sequence = std::min(last->last_sequence, std::max(sequence, last->first_sequence));
  last->last_stamp_ns = last->keyframes.back().stamp_ns;
  robot->submaps.back() = std::move(last);
}

}  // namespace isthmus::bench
