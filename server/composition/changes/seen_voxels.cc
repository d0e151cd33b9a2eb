#include "server/composition/changes/seen_voxels.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <optional>

#include "server/composition/changes/limits.h"

namespace isthmus::composition {
namespace {

Voxel Moved(const Voxel& v, const Eigen::Vector3i& by) {
  return {v.x + by.x(), v.y + by.y(), v.z + by.z()};
}

Voxel Moved(const Voxel& v, int x, int y) { return {v.x + x, v.y + y, v.z}; }

}  // namespace

SeenVoxels::SeenVoxels(const RegionExtent& extent)
    : extent_(extent), grid_(kComparedVoxelM), columns_(kColumnM), parts_(kPartM) {
  constexpr int kReach = kDriftedVoxels;
  for (int x = -kReach; x <= kReach; ++x) {
    for (int y = -kReach; y <= kReach; ++y) {
      for (int z = -kReach; z <= kReach; ++z) {
        const Eigen::Vector3i to(x, y, z);
        if (to.squaredNorm() <= kReach * kReach) around_.push_back(to);
      }
    }
  }
  std::ranges::stable_sort(around_, {}, [](const Eigen::Vector3i& to) { return to.squaredNorm(); });
}

bool SeenVoxels::Add(uint32_t index, const ComparedSubmap& compared, const Submap& submap,
                     const KeepOn& keep_on) {
  const Eigen::Matrix3f R = compared.placed.T_map_submap.RotationMatrix().cast<float>();
  const Eigen::Vector3f t = compared.placed.T_map_submap.translation().cast<float>();
  for (size_t i = 0; i < submap.points.size(); ++i) {
    if (i % kRaysAtOnce == 0 && !keep_on()) return false;
    const SubmapPoint& point = submap.points[i];
    const Eigen::Vector3f at = R * point.Position() + t;
    const std::optional<Voxel> voxel = grid_.Find(at.x(), at.y(), at.z());
    if (!voxel) continue;
    const auto [it, is_new] =
        numbers_.try_emplace(SideKey(*voxel, compared.is_after), seen_.size());
    const int64_t stamp_ns = submap.keyframes[point.keyframe].stamp_ns;
    if (is_new) {
      const Pose& T_submap_sensor = submap.keyframes[point.keyframe].T_submap_sensor;
      const Eigen::Vector3f from = R * T_submap_sensor.translation().cast<float>() + t;
      Eigen::Vector3f along = (at - from).stableNormalized();
      if (!along.allFinite()) along.setZero();  // A sensor that stood nowhere.
      seen_.push_back({*voxel, compared.is_after, index, 0, 0, stamp_ns, stamp_ns, along});
      const Voxel column = *columns_.Find(at.x(), at.y(), 0);
      Heights& heights =
          heights_.try_emplace(SideKey(column, compared.is_after), Heights{at.z(), at.z()})
              .first->second;
      heights.lowest = std::min(heights.lowest, at.z());
      heights.highest = std::max(heights.highest, at.z());
    }
    Seen& seen = seen_[it->second];
    seen.first_ns = std::min(seen.first_ns, stamp_ns);
    seen.last_ns = std::max(seen.last_ns, stamp_ns);
    const uint64_t keyframe = (uint64_t{index} + 1) << 16 | point.keyframe;
    if (seen.last_keyframe != keyframe) ++seen.hits;
    seen.last_keyframe = keyframe;
  }
  return true;
}

bool SeenVoxels::IsFloorOrCeiling(const Seen& seen) const {
  const Eigen::Vector3f at = MiddleOf(seen.voxel, kComparedVoxelM);
  const Voxel column = *columns_.Find(at.x(), at.y(), 0);
  Heights around{at.z(), at.z()};
  for (int i = 0; i < 9; ++i) {
    const auto it = heights_.find(SideKey(Moved(column, i % 3 - 1, i / 3 - 1), seen.after));
    if (it == heights_.end()) continue;
    around.lowest = std::min(around.lowest, it->second.lowest);
    around.highest = std::max(around.highest, it->second.highest);
  }
  if (at.z() < around.lowest + kGroundM) return true;
  return at.z() > around.highest - kGroundM && at.z() > around.lowest + kCeilingM;
}

Eigen::Vector3i SeenVoxels::ToOther(const Seen& seen) const {
  for (const Eigen::Vector3i& to : around_) {
    if (numbers_.contains(SideKey(Moved(seen.voxel, to), !seen.after))) return to;
  }
  return Eigen::Vector3i::Zero();
}

Eigen::Vector3f SeenVoxels::Inward(const Seen& seen) const {
  constexpr int kFewest = 5;  // Less than a surface of three by three.
  std::vector<Eigen::Vector3f> near;
  for (const Eigen::Vector3i& to : around_) {
    if (to.squaredNorm() > kNormalVoxels * kNormalVoxels) break;
    if (numbers_.contains(SideKey(Moved(seen.voxel, to), seen.after))) {
      near.push_back(to.cast<float>());
    }
  }
  if (near.size() < kFewest) return seen.along;
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  for (const Eigen::Vector3f& to : near) mean += to / static_cast<float>(near.size());
  Eigen::Matrix3f spread = Eigen::Matrix3f::Zero();
  for (const Eigen::Vector3f& to : near) spread += (to - mean) * (to - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes(spread);
  const Eigen::Vector3f normal = axes.eigenvectors().col(0);
  return normal.dot(seen.along) < 0 ? Eigen::Vector3f(-normal) : normal;
}

std::vector<ChangedPoint> SeenVoxels::OfOneSide(const KeepOn& keep_on) const {
  std::vector<ChangedPoint> points;
  absl::flat_hash_map<uint64_t, Times, VoxelHash> times;  // By side and part.
  const auto part_of = [this](const Seen& seen) {
    const Eigen::Vector3f at = MiddleOf(seen.voxel, kComparedVoxelM);
    return SideKey(*parts_.Find(at.x(), at.y(), at.z()), seen.after);
  };
  for (size_t i = 0; i < seen_.size(); ++i) {
    if (i % kRaysAtOnce == 0 && !keep_on()) return {};
    const Seen& seen = seen_[i];
    const Eigen::Vector3f at = MiddleOf(seen.voxel, kComparedVoxelM);
    if (numbers_.contains(SideKey(seen.voxel, !seen.after)) ||
        !extent_.Contains(at.cast<double>()) || IsFloorOrCeiling(seen)) {
      continue;
    }
    const Eigen::Vector3i to = ToOther(seen);
    const bool is_near = to != Eigen::Vector3i::Zero();
    if (is_near && to.squaredNorm() <= kStillThereVoxels * kStillThereVoxels) continue;
    ChangedPoint& point = points.emplace_back();
    point.at = at;
    point.came = seen.after;
    point.seen_by = seen.submap;
    point.hits = seen.hits;
    point.inward = Inward(seen);
    if (is_near) point.to_other = to.cast<float>() * static_cast<float>(kComparedVoxelM);
    times.try_emplace(part_of(seen), Times{seen.first_ns, seen.last_ns});
  }
  for (const Seen& seen : seen_) {
    const auto it = times.find(part_of(seen));
    if (it == times.end()) continue;
    it->second.first_ns = std::min(it->second.first_ns, seen.first_ns);
    it->second.last_ns = std::max(it->second.last_ns, seen.last_ns);
  }
  for (ChangedPoint& point : points) {
    const Voxel part = *parts_.Find(point.at.x(), point.at.y(), point.at.z());
    const Times& seen = times.at(SideKey(part, point.came));
    point.first_ns = seen.first_ns;
    point.last_ns = seen.last_ns;
  }
  return points;
}

}  // namespace isthmus::composition
