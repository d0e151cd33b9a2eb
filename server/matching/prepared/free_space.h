// Does one map put a wall where the other robot looked through? The test that tells right merges
// from wrong ones: inliers, overlap and residuals do not (two identical rooms agree perfectly).
#pragma once

#include <absl/container/flat_hash_set.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "core/map/submap.h"
#include "core/pose.h"
#include "server/matching/prepared/limits.h"
#include "server/matching/prepared/map_poses.h"
#include "server/matching/prepared/prepared_submap.h"

namespace isthmus::matching {

struct FreeSpaceOptions {
  // A point contradicts when it lies so much, and so much of the range, in front of what was
  // measured.
  double margin_m = kFreeSpaceMarginM, margin_per_m = kFreeSpaceMarginPerM;
  // Metres from the view: farther, a bin of 2 degrees is as wide as a door. A guess, as is For's.
  double max_range_m = 25;
  // |n_z| up to which surfaces are asked: near-vertical ones, as rays meet floors at a slant.
  double max_abs_normal_z = kMaxUprightNormalZ;

  // Outdoors ways come less near each other, and walls are large: farther ones have a say too.
  static FreeSpaceOptions For(bool outdoors) {
    FreeSpaceOptions options;
    if (outdoors) options.max_range_m = 40;
    return options;
  }
};

struct FreeSpaceScore {
  int64_t agree = 0;  // The point lies at the measured range.
  int64_t front = 0;  // The point lies in front of it: contradicted.
  int64_t comparisons() const { return agree + front; }
  // Share of contradicted comparisons in [0, 1]; 0 without comparisons, which is not evidence.
  double violation() const {
    return comparisons() ? static_cast<double>(front) / static_cast<double>(comparisons()) : 0;
  }
  // Agreement less contradiction, such that with this share contradicted nothing is left. Large
  // where much was compared and little contradicted.
  double Support(double max_violation) const {
    return static_cast<double>(agree) -
           static_cast<double>(front) * (1 - max_violation) / max_violation;
  }
  // The same by place, so that a large hall does not dilute one wing: columns of points as the
  // views of one submap see them, and those of which half and more is contradicted.
  int64_t regions = 0, contradicted_regions = 0;
  FreeSpaceScore& operator+=(const FreeSpaceScore& other) {
    agree += other.agree;
    front += other.front;
    regions += other.regions;
    contradicted_regions += other.contradicted_regions;
    return *this;
  }
};

// A map made ready for free-space checks: of every submap the near-vertical surface points that are
// asked of the other map's views. Immutable; safe to read from many threads.
class FreeSpaceMap {
 public:
  struct Column {  // Points of one square of the ground plane, submap frame.
    Eigen::Vector3f center;
    std::vector<SurfacePoint> points;
  };
  struct Piece {
    std::shared_ptr<const PreparedSubmap> submap;
    std::vector<Column> columns;  // A place that several submaps show is asked of the first.
  };

  FreeSpaceMap() = default;
  // `T_level_odom` makes the map level.
  FreeSpaceMap(const PreparedSubmaps& submaps, const Pose& T_level_odom,
               const FreeSpaceOptions& options);
  // `before` grown by the submaps that it has not: what it takes does not depend on its size, but
  // on what lies near the new ones. What moved is known better by then: some old points go.
  FreeSpaceMap(FreeSpaceMap before, const PreparedSubmaps& submaps, const Pose& T_level_odom,
               const FreeSpaceOptions& options);

  const std::vector<std::shared_ptr<const Piece>>& pieces() const { return pieces_; }

 private:
  void Add(const std::shared_ptr<const PreparedSubmap>& submap, const Pose& T_level_odom,
           const FreeSpaceOptions& options);
  // Takes out what the map's own views contradict: people, cars, foliage. Old pieces are asked of
  // the views of new ones only.
  void DropFleeting(size_t first_new, const FreeSpaceOptions& options);
  // Takes out of new pieces what stands alone and is no larger than a person: who stood still while
  // the robot looked, and chairs and boxes, which are moved. A larger thing is judged as a whole.
  void DropSmall(size_t first_new, const Pose& T_level_odom);

  std::vector<std::shared_ptr<const Piece>> pieces_;
  absl::flat_hash_set<uint64_t> taken_;  // Voxels of the odom frame that have a point.
};

// Both ways: a's points against b's views and b's against a's. `first_a` and `first_b`: only pairs
// of submaps of which one is that far or farther in its map, to add to an earlier score. Thread
// safe.
FreeSpaceScore ScoreFreeSpace(const FreeSpaceMap& a, const FreeSpaceMap& b, const MapPoses& poses,
                              const FreeSpaceOptions& options, size_t first_a = 0,
                              size_t first_b = 0);

}  // namespace isthmus::matching
