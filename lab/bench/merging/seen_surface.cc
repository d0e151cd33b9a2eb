#include "lab/bench/merging/seen_surface.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>

namespace isthmus::bench {
namespace {

constexpr uint64_t kStride = 10;  // Scans, when looking for stretches.

// A ceiling and the floor above it lie in one cell, but one is seen from below.
uint64_t CellOf(const Eigen::Vector3d& point, const Eigen::Vector3d& sensor, double cell_m) {
  uint64_t key = point.z() > sensor.z() ? 1 : 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cell = static_cast<int64_t>(std::floor(point[axis] / cell_m));
    key = (key << 20) | (static_cast<uint64_t>(cell) & 0xFFFFF);
  }
  return key;
}

}  // namespace

SeenSurface::SeenSurface(const DrivenRobot& robot) {
  for (const auto& submap : robot.submaps) {
    std::vector<Pose> T_world_submap;  // By keyframe.
    for (const Keyframe& keyframe : submap->keyframes) {
      const ScanPose* pose = robot.FindPose(keyframe.sequence);
      T_world_submap.push_back(
          pose == nullptr ? Pose() : pose->T_world_sensor * keyframe.T_submap_sensor.Inverse());
    }
    for (const SubmapPoint& point : submap->points) {
      const Eigen::Vector3d at =
          T_world_submap[point.keyframe] * point.Position().cast<double>().eval();
      const Eigen::Vector3d sensor =
          T_world_submap[point.keyframe] *
          submap->keyframes[point.keyframe].T_submap_sensor.translation();
      const uint64_t sequence = submap->keyframes[point.keyframe].sequence;
      ScanRange& seen =
          cells_
              .try_emplace(CellOf(at, sensor, robot.overlap_cell_m), ScanRange{sequence, sequence})
              .first->second;
      seen = {std::min(seen.first, sequence), std::max(seen.last, sequence)};
    }
  }
}

size_t SeenSurface::Count(const ScanRange& range) const {
  return static_cast<size_t>(std::count_if(cells_.begin(), cells_.end(), [&](const auto& cell) {
    return Contains(range, cell.second);
  }));
}

double SeenSurface::Overlap(const SeenSurface& a, const SeenSurface& b, const ScanRange& of_a,
                            const ScanRange& of_b) {
  const size_t least = std::min(a.Count(of_a), b.Count(of_b));
  if (least == 0) return 0;
  const auto common = std::count_if(a.cells_.begin(), a.cells_.end(), [&](const auto& cell) {
    if (!Contains(of_a, cell.second)) return false;
    const auto it = b.cells_.find(cell.first);
    return it != b.cells_.end() && Contains(of_b, it->second);
  });
  return static_cast<double>(common) / static_cast<double>(least);
}

std::optional<std::pair<ScanRange, ScanRange>> FindScanRanges(const DrivenRobot& a,
                                                              const DrivenRobot& b,
                                                              const OverlapRange& range,
                                                              bool ends_too) {
  const SeenSurface seen_a(a), seen_b(b);
  const uint64_t last = std::max(a.poses.back().sequence, b.poses.back().sequence);
  for (uint64_t length = last; length > kStride; length -= kStride) {
    const ScanRange beginning{0, length}, end{last + 1 - length, UINT64_MAX};
    for (const ScanRange& of_a : {beginning, end}) {
      for (const ScanRange& of_b : {beginning, end}) {
        if (!ends_too && (of_a.first > 0 || of_b.first > 0)) continue;
        const double overlap = SeenSurface::Overlap(seen_a, seen_b, of_a, of_b);
        if (overlap >= range.least && overlap <= range.most) return std::pair(of_a, of_b);
      }
    }
  }
  return std::nullopt;
}

namespace {

// The submap's first keyframes, as many as were made until that scan, one at least.
std::shared_ptr<const Submap> Beginning(const Submap& submap, uint64_t sequence) {
  auto cut = std::make_shared<Submap>(submap);
  size_t kept = 1;
  while (kept < cut->keyframes.size() && cut->keyframes[kept].sequence <= sequence) ++kept;
  cut->keyframes.resize(kept);
  std::erase_if(cut->points, [&](const SubmapPoint& p) { return p.keyframe >= kept; });
  cut->last_sequence = std::min(cut->last_sequence, std::max(sequence, cut->first_sequence));
  cut->last_stamp_ns = cut->keyframes.back().stamp_ns;
  return cut;
}

}  // namespace

void KeepScans(const ScanRange& range, DrivenRobot* robot) {
  if (range.first == 0 && range.last == UINT64_MAX) return;
  auto& submaps = robot->submaps;
  size_t begin = 0, end = submaps.size();
  while (begin + 1 < end && submaps[begin]->first_sequence < range.first) ++begin;
  while (begin + 1 < end && submaps[end - 1]->keyframes.front().sequence > range.last) --end;
  const auto at = [&](size_t i) { return submaps.begin() + static_cast<std::ptrdiff_t>(i); };
  submaps = std::vector(at(begin), at(end));
  submaps.back() = Beginning(*submaps.back(), range.last);
  for (size_t i = 0; i < submaps.size(); ++i) {
    auto renumbered = std::make_shared<Submap>(*submaps[i]);
    renumbered->id.index = static_cast<uint32_t>(i);
    submaps[i] = std::move(renumbered);
  }
  const uint64_t first = submaps.front()->first_sequence, last = submaps.back()->last_sequence;
  std::erase_if(robot->poses, [&](const ScanPose& pose) {
    return pose.sequence < first || pose.sequence > last;
  });
  for (ScanPose& pose : robot->poses) pose.submap -= static_cast<uint32_t>(begin);
}

}  // namespace isthmus::bench
