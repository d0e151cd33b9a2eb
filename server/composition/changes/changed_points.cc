#include "server/composition/changes/changed_points.h"

#include <absl/container/flat_hash_map.h>
#include <absl/container/flat_hash_set.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "core/map/region_extent.h"
#include "server/composition/changes/limits.h"
#include "server/composition/changes/seen_voxels.h"

namespace isthmus::composition {
namespace {

constexpr int kSteps = static_cast<int>(2 * kStrideM / kPassedCellM);  // Math: half a cell each.
constexpr int32_t kNone = -1;                                          // Layout.

// Cells that rays may pass: those of points, and those behind them.
class RayTargets {
 public:
  explicit RayTargets(std::vector<ChangedPoint> points)
      : points_(std::move(points)), grid_(kPassedCellM), strides_(kStrideM) {
    for (const ChangedPoint& point : points_) {
      at_.push_back(Add(point.at, point.came));
      behind_.push_back(Add(point.at + kPassedBehindM * point.inward, point.came));
    }
  }

  bool MayTouch(const Box& box) const { return bounds_.Intersects(box); }

  // Follows the submap's rays. False when told to end.
  bool Pass(uint32_t index, const ComparedSubmap& compared, const Submap& submap,
            const KeepOn& keep_on) {
    const Pose& T_map_submap = compared.placed.T_map_submap;
    const Eigen::Matrix3f R = T_map_submap.RotationMatrix().cast<float>();
    const Eigen::Vector3f t = T_map_submap.translation().cast<float>();
    for (size_t i = 0; i < submap.points.size(); ++i) {
      if (i % kRaysAtOnce == 0 && !keep_on()) return false;
      const SubmapPoint& point = submap.points[i];
      const Keyframe& keyframe = submap.keyframes[point.keyframe];
      const Look look{index, compared.is_after, (uint64_t{index} + 1) << 16 | point.keyframe,
                      keyframe.stamp_ns};
      Follow(look, R * keyframe.T_submap_sensor.translation().cast<float>() + t,
             R * point.Position() + t);
    }
    return true;
  }

  // Points that were passed, and that did not move by their own side's looks.
  std::vector<ChangedPoint> Take() && {
    size_t kept = 0;
    for (size_t i = 0; i < points_.size(); ++i) {
      const Target& target = targets_[at_[i]];
      if (target.passes < kFewestPasses || target.own_passes > kOwnPassesPerHit * points_[i].hits) {
        continue;
      }
      ChangedPoint& point = points_[kept++] = points_[i];
      point.passes = target.passes;
      point.passes_behind = targets_[behind_[i]].passes;
      point.missing_ns = target.missing_ns;
      point.missed_by = target.missed_by;
    }
    points_.resize(kept);
    return std::move(points_);
  }

 private:
  struct Target {
    bool came = false;
    uint32_t passes = 0, own_passes = 0, missed_by = 0;
    uint64_t last_pass = 0, last_own_pass = 0;  // Keyframes.
    int64_t missing_ns = 0;
  };
  struct Sides {
    int32_t went = kNone, came = kNone;
  };
  struct Look {
    uint32_t submap;
    bool after;
    uint64_t keyframe;
    int64_t stamp_ns;
  };

  // Its number.
  int32_t Add(const Eigen::Vector3f& at, bool came) {
    bounds_.Extend(at.cast<double>());
    const Voxel near = *strides_.Find(at.x(), at.y(), at.z());
    for (int k = 0; k < 27; ++k) {
      near_.insert(PackVoxel({near.x + k % 3 - 1, near.y + k / 3 % 3 - 1, near.z + k / 9 - 1}));
    }
    Sides& sides =
        numbers_.try_emplace(PackVoxel(*grid_.Find(at.x(), at.y(), at.z()))).first->second;
    int32_t& number = came ? sides.came : sides.went;
    if (number == kNone) {
      number = static_cast<int32_t>(targets_.size());
      targets_.push_back({.came = came});
    }
    return number;
  }

  void Follow(const Look& look, const Eigen::Vector3f& from, const Eigen::Vector3f& to) {
    const float range = (to - from).norm();
    const float end = std::min(range - kRayEndM - kRayEndPerM * range, kRayToM);
    if (!(end > kRayFromM)) return;  // Nor where something is not finite.
    const Eigen::Vector3f along = (to - from) / range;
    for (float begin = kRayFromM; begin < end; begin += kStrideM) {
      const Eigen::Vector3f at = from + begin * along;
      const std::optional<Voxel> stride = strides_.Find(at.x(), at.y(), at.z());
      if (!stride || !near_.contains(PackVoxel(*stride))) continue;
      for (int k = 0; k < kSteps; ++k) {
        const float s = begin + kStrideM / kSteps * static_cast<float>(k);
        if (s >= end) return;
        PassAt(look, from + s * along);
      }
    }
  }

  void PassAt(const Look& look, const Eigen::Vector3f& at) {
    const std::optional<Voxel> cell = grid_.Find(at.x(), at.y(), at.z());
    if (!cell) return;
    const auto it = numbers_.find(PackVoxel(*cell));
    if (it == numbers_.end()) return;
    const int32_t other = look.after ? it->second.went : it->second.came;
    const int32_t own = look.after ? it->second.came : it->second.went;
    if (own != kNone) {
      Target& target = targets_[own];
      if (std::exchange(target.last_own_pass, look.keyframe) != look.keyframe) ++target.own_passes;
    }
    if (other == kNone) return;
    Target& target = targets_[other];
    if (std::exchange(target.last_pass, look.keyframe) == look.keyframe) return;
    const bool tells_when =
        target.came ? look.stamp_ns > target.missing_ns : look.stamp_ns < target.missing_ns;
    if (target.passes++ > 0 && !tells_when) return;
    target.missing_ns = look.stamp_ns;
    target.missed_by = look.submap;
  }

  std::vector<ChangedPoint> points_;
  std::vector<int32_t> at_, behind_;  // The targets of each.
  std::vector<Target> targets_;
  Box bounds_;
  const VoxelGrid grid_, strides_;
  absl::flat_hash_map<uint64_t, Sides, VoxelHash> numbers_;  // By cell.
  absl::flat_hash_set<uint64_t, VoxelHash> near_;            // Strides that may meet any.
};

absl::Status Ended() { return absl::CancelledError("stopped"); }

absl::Status TooMuch() {
  return absl::ResourceExhaustedError(
      absl::StrCat("there are more than ", kMostComparedVoxels,
                   " voxels to compare, too many for one call: ask for a part of the map"));
}

}  // namespace

absl::StatusOr<std::vector<ChangedPoint>> FindChangedPoints(
    const std::vector<ComparedSubmap>& submaps, const SubmapReader& reader, const Region& region,
    const KeepOn& keep_on) {
  const auto bounds_of = [](const ComparedSubmap& compared) {
    return Transform(compared.placed.T_map_submap, compared.placed.submap->bounds);
  };
  const RegionExtent extent(region);
  std::vector<ChangedPoint> of_one_side;
  {
    SeenVoxels seen(extent);
    for (uint32_t i = 0; i < submaps.size(); ++i) {
      const Box near = bounds_of(submaps[i]).Grown(kDriftedVoxels * kComparedVoxelM);
      if (!extent.MayTouch(near)) continue;
      const std::shared_ptr<const Submap> submap = reader(submaps[i].placed.submap->id);
      if (submap == nullptr) continue;
      if (!seen.Add(i, submaps[i], *submap, keep_on)) return Ended();
      if (seen.size() > kMostComparedVoxels) return TooMuch();
    }
    of_one_side = seen.OfOneSide(keep_on);
  }
  RayTargets targets(std::move(of_one_side));
  for (uint32_t i = 0; i < submaps.size(); ++i) {
    if (!keep_on()) return Ended();
    // Sensors stand among the points that they see, or near.
    if (!targets.MayTouch(bounds_of(submaps[i]).Grown(kRayToM))) continue;
    const std::shared_ptr<const Submap> submap = reader(submaps[i].placed.submap->id);
    if (submap == nullptr) continue;
    if (!targets.Pass(i, submaps[i], *submap, keep_on)) return Ended();
  }
  return std::move(targets).Take();
}

}  // namespace isthmus::composition
