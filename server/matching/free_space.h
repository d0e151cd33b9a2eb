// Does one map put a wall where the other robot looked through? The test that tells right merges
// from wrong ones: inliers, overlap and residuals do not (two identical rooms agree perfectly).
#pragma once

#include <cstdint>
#include <vector>

#include "core/pose.h"
#include "core/submap.h"
#include "server/matching/range_image.h"
#include "server/matching/surface.h"

namespace isthmus::matching {

struct FreeSpaceOptions {
  double margin_m = 0.4;       // A point contradicts when it lies this much ...
  double margin_per_m = 0.01;  // ... plus this share of the range in front of what was measured.
  double max_range_m = 25;
  double max_abs_normal_z = 0.5;  // Only near-vertical surfaces are asked.
};

struct FreeSpaceScore {
  int64_t agree = 0;  // The point lies at the measured range.
  int64_t front = 0;  // The point lies in front of it: contradicted.
  int64_t comparisons() const { return agree + front; }
  // Share of contradicted comparisons in [0, 1]; 0 without comparisons, which is not evidence.
  double violation() const {
    return comparisons() ? static_cast<double>(front) / static_cast<double>(comparisons()) : 0;
  }
};

// A map made ready for free-space checks once: range images of its keyframes, and the near-vertical
// surface points that are asked of other maps' images. Immutable; safe to read from many threads.
class FreeSpaceMap {
 public:
  // `surface` as sampled from the map, odom frame; `T_level_odom` makes it level.
  FreeSpaceMap(const SessionMap& map, const std::vector<SurfacePoint>& surface,
               const Pose& T_level_odom, const FreeSpaceOptions& options);

  struct View {
    Pose T_odom_sensor;
    RangeImage image;
  };
  struct Column {  // Points of one square of the ground plane.
    Eigen::Vector3f center;
    std::vector<SurfacePoint> points;
  };
  const std::vector<View>& views() const { return views_; }
  const std::vector<Column>& columns() const { return columns_; }

 private:
  void CollectViews(const SessionMap& map);
  void CollectColumns(const std::vector<SurfacePoint>& surface, const Pose& T_level_odom,
                      const FreeSpaceOptions& options);
  // Takes out what the map's own views contradict: people, cars, foliage.
  void DropFleeting(const FreeSpaceOptions& options);

  std::vector<View> views_;
  std::vector<Column> columns_;
};

// Both ways: a's points against b's keyframes' range images and b's against a's. Thread safe.
FreeSpaceScore ScoreFreeSpace(const SessionMap& a, const SessionMap& b, const Pose& T_a_b,
                              const FreeSpaceOptions& options);
FreeSpaceScore ScoreFreeSpace(const FreeSpaceMap& a, const FreeSpaceMap& b, const Pose& T_a_b,
                              const FreeSpaceOptions& options);

}  // namespace isthmus::matching
