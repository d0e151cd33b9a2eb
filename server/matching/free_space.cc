#include "server/matching/free_space.h"

#include <absl/container/flat_hash_map.h>
#include <absl/container/flat_hash_set.h>

#include <cmath>
#include <vector>

#include "server/matching/gravity.h"
#include "server/matching/voxel_key.h"

namespace isthmus::matching {
namespace {

constexpr double kSurfaceVoxelM = 0.25;
constexpr float kPointSpacingM = 0.4f;
constexpr float kColumnM = 4.0f;
constexpr double kViewSpacingM = 1.0;
constexpr double kViewTurnRad = 0.5;
// A surface seen this flat has no range of its own in a bin two degrees wide.
constexpr float kMinIncidenceCos = 0.2f;
// Nearer than this the robot itself and the bins' smallness spoil the comparison.
constexpr float kMinRangeM = 1.0f;
// A point that its own map contradicts more often is of something that moved.
constexpr float kMaxFleeting = 0.2f;
// A point that fewer views agree on may be so too.
constexpr int kMinViews = 3;

// What one point of another map, or of the same, is to a view: +1 in front of what was measured,
// -1 at the range measured, 0 without a say (outside, occluded, grazing, at an edge of depth).
class Comparer {
 public:
  Comparer(const FreeSpaceMap::View& view, const Pose& T_odom_points,
           const FreeSpaceOptions& options)
      : view_(view), options_(options) {
    const Pose T_sensor_points = view.T_odom_sensor.Inverse() * T_odom_points;
    R_ = T_sensor_points.RotationMatrix().cast<float>();
    t_ = T_sensor_points.translation().cast<float>();
    max_range_ = static_cast<float>(options.max_range_m);
  }

  bool Reaches(const FreeSpaceMap::Column& column) const {
    const float reach = max_range_ + kColumnM;
    return (R_ * column.center + t_).squaredNorm() < reach * reach;
  }

  int Compare(const SurfacePoint& point) const {
    const Eigen::Vector3f p = R_ * point.position + t_;
    const float range = p.norm();
    if (range < kMinRangeM || range > max_range_) return 0;
    if (std::abs((R_ * point.normal).dot(p)) < kMinIncidenceCos * range) return 0;
    RangeImage::Interval seen;
    if (!view_.image.At(p, &seen)) return 0;
    const float margin = static_cast<float>(options_.margin_m) +
                         static_cast<float>(options_.margin_per_m) * seen.shortest;
    if (range < seen.shortest - margin) return 1;
    const bool agrees =
        std::abs(range - seen.shortest) < margin || std::abs(range - seen.longest) < margin;
    return agrees ? -1 : 0;
  }

 private:
  const FreeSpaceMap::View& view_;
  const FreeSpaceOptions& options_;
  Eigen::Matrix3f R_;
  Eigen::Vector3f t_;
  float max_range_ = 0;
};

// One way: the points of `columns` against `views`.
void Compare(const std::vector<FreeSpaceMap::View>& views,
             const std::vector<FreeSpaceMap::Column>& columns, const Pose& T_views_points,
             const FreeSpaceOptions& options, FreeSpaceScore* score) {
  for (const FreeSpaceMap::View& view : views) {
    const Comparer comparer(view, T_views_points, options);
    for (const FreeSpaceMap::Column& column : columns) {
      if (!comparer.Reaches(column)) continue;
      for (const SurfacePoint& point : column.points) {
        const int verdict = comparer.Compare(point);
        score->front += verdict > 0;
        score->agree += verdict < 0;
      }
    }
  }
}

}  // namespace

FreeSpaceMap::FreeSpaceMap(const SessionMap& map, const std::vector<SurfacePoint>& surface,
                           const Pose& T_level_odom, const FreeSpaceOptions& options) {
  CollectViews(map);
  CollectColumns(surface, T_level_odom, options);
  DropFleeting(options);
}

void FreeSpaceMap::CollectViews(const SessionMap& map) {
  for (const auto& submap : map.submaps) {
    std::vector<std::vector<Eigen::Vector3f>> points(submap->keyframes.size());
    for (const SubmapPoint& point : submap->points) {
      if (point.keyframe < points.size()) points[point.keyframe].push_back(point.Position());
    }
    for (size_t k = 0; k < submap->keyframes.size(); ++k) {
      const Pose& T_submap_sensor = submap->keyframes[k].T_submap_sensor;
      const Pose T_odom_sensor = submap->T_odom_submap * T_submap_sensor;
      if (!views_.empty()) {
        const Pose T_last = views_.back().T_odom_sensor.Inverse() * T_odom_sensor;
        if (T_last.translation().norm() < kViewSpacingM && RotationAngle(T_last) < kViewTurnRad) {
          continue;
        }
      }
      const Pose T_sensor_submap = T_submap_sensor.Inverse();
      const Eigen::Matrix3f R = T_sensor_submap.RotationMatrix().cast<float>();
      const Eigen::Vector3f t = T_sensor_submap.translation().cast<float>();
      for (Eigen::Vector3f& p : points[k]) p = R * p + t;
      views_.push_back({T_odom_sensor, RangeImage(points[k])});
    }
  }
}

void FreeSpaceMap::CollectColumns(const std::vector<SurfacePoint>& surface,
                                  const Pose& T_level_odom, const FreeSpaceOptions& options) {
  const Eigen::Vector3f up =
      (T_level_odom.rotation().inverse() * Eigen::Vector3d::UnitZ()).cast<float>();
  const auto max_normal_z = static_cast<float>(options.max_abs_normal_z);
  absl::flat_hash_set<uint64_t> taken;
  absl::flat_hash_map<uint64_t, int> column_of;
  for (const SurfacePoint& point : surface) {
    if (std::abs(point.normal.dot(up)) > max_normal_z) continue;
    if (!taken.insert(VoxelKey(point.position, 1 / kPointSpacingM)).second) continue;
    const Eigen::Vector3f& p = point.position;
    const auto [entry, added] =
        column_of.try_emplace(VoxelKey(p, 1 / kColumnM), static_cast<int>(columns_.size()));
    if (added) {
      columns_.push_back({((p / kColumnM).array().floor() + 0.5f) * kColumnM, {}});
    }
    columns_[entry->second].points.push_back(point);
  }
}

void FreeSpaceMap::DropFleeting(const FreeSpaceOptions& options) {
  std::vector<Comparer> comparers;
  comparers.reserve(views_.size());
  for (const View& view : views_) comparers.emplace_back(view, Pose(), options);
  std::vector<const Comparer*> near;
  for (Column& column : columns_) {
    near.clear();
    for (const Comparer& comparer : comparers) {
      if (comparer.Reaches(column)) near.push_back(&comparer);
    }
    std::erase_if(column.points, [&](const SurfacePoint& point) {
      int front = 0, agree = 0;
      for (const Comparer* comparer : near) {
        const int verdict = comparer->Compare(point);
        front += verdict > 0;
        agree += verdict < 0;
      }
      return agree < kMinViews || front > kMaxFleeting * static_cast<float>(front + agree);
    });
  }
}

FreeSpaceScore ScoreFreeSpace(const FreeSpaceMap& a, const FreeSpaceMap& b, const Pose& T_a_b,
                              const FreeSpaceOptions& options) {
  FreeSpaceScore score;
  Compare(a.views(), b.columns(), T_a_b, options, &score);
  Compare(b.views(), a.columns(), T_a_b.Inverse(), options, &score);
  return score;
}

FreeSpaceScore ScoreFreeSpace(const SessionMap& a, const SessionMap& b, const Pose& T_a_b,
                              const FreeSpaceOptions& options) {
  const auto prepare = [&](const SessionMap& map) {
    const std::vector<SurfacePoint> surface = SampleSurface(map, kSurfaceVoxelM);
    const Pose T_level_odom(EstimateLevel(surface), Eigen::Vector3d::Zero());
    return FreeSpaceMap(map, surface, T_level_odom, options);
  };
  return ScoreFreeSpace(prepare(a), prepare(b), T_a_b, options);
}

}  // namespace isthmus::matching
