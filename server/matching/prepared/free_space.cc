#include "server/matching/prepared/free_space.h"

#include <absl/container/flat_hash_map.h>
#include <absl/container/flat_hash_set.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/matching/prepared/limits.h"
#include "server/matching/registration/limits.h"
#include "server/matching/registration/voxel_key.h"

namespace isthmus::matching {
namespace {

// Compares one point of another map, or of the same, with a view: +1 in front of what was measured,
// -1 at the range measured, 0 without a say (outside, occluded, grazing, at an edge of depth).
class Comparer {
 public:
  Comparer(const PreparedSubmap::View& view, const Pose& T_submap_points,
           const FreeSpaceOptions& options)
      : view_(view), options_(options) {
    const Pose T_sensor_points = view.T_submap_sensor.Inverse() * T_submap_points;
    R_ = T_sensor_points.RotationMatrix().cast<float>();
    t_ = T_sensor_points.translation().cast<float>();
    max_range_ = static_cast<float>(options.max_range_m);
  }

  bool Reaches(const FreeSpaceMap::Column& column) const {
    const float reach = max_range_ + kAskedColumnM;
    return (R_ * column.center + t_).squaredNorm() < reach * reach;
  }

  int Compare(const SurfacePoint& point) const {
    const Eigen::Vector3f p = R_ * point.position + t_;
    const float range = p.norm();
    if (range < kMinComparedM || range > max_range_) return 0;
    if (std::abs((R_ * point.normal).dot(p)) < kMinIncidenceCosine * range) return 0;
    RangeImage::Interval seen;
    if (!view_.image.At(p, &seen)) return 0;
    const float margin = static_cast<float>(options_.margin_m) +
                         static_cast<float>(options_.margin_per_m) * seen.shortest;
    return seen.Compare(range, margin);
  }

 private:
  const PreparedSubmap::View& view_;
  const FreeSpaceOptions& options_;
  Eigen::Matrix3f R_;
  Eigen::Vector3f t_;
  float max_range_ = 0;
};

// One way: the points of a piece against the views of another map's submap.
void Compare(const PreparedSubmap& views, const FreeSpaceMap::Piece& piece,
             const Pose& T_views_points, const FreeSpaceOptions& options, FreeSpaceScore* score) {
  if (!Meet(views, *piece.submap, T_views_points, options.max_range_m)) return;
  std::vector<FreeSpaceScore> regions(piece.columns.size());
  for (const PreparedSubmap::View& view : views.views()) {
    const Comparer comparer(view, T_views_points, options);
    for (size_t i = 0; i < piece.columns.size(); ++i) {
      if (!comparer.Reaches(piece.columns[i])) continue;
      for (const SurfacePoint& point : piece.columns[i].points) {
        const int compared = comparer.Compare(point);
        regions[i].front += compared > 0;
        regions[i].agree += compared < 0;
      }
    }
  }
  FreeSpaceScore sum;
  for (const FreeSpaceScore& region : regions) {
    sum.front += region.front;
    sum.agree += region.agree;
    if (region.comparisons() < kMinRegionComparisons) continue;
    ++sum.regions;
    sum.contradicted_regions += region.violation() >= kContradictedRegion;
  }
  *score += sum;
}

// The scores of the piece's points by the views of the submaps.
std::vector<FreeSpaceScore> AskOwnViews(const FreeSpaceMap::Piece& piece,
                                        const std::vector<const PreparedSubmap*>& submaps,
                                        const FreeSpaceOptions& options) {
  size_t count = 0;
  for (const FreeSpaceMap::Column& column : piece.columns) count += column.points.size();
  std::vector<FreeSpaceScore> scores(count);
  for (const PreparedSubmap* submap : submaps) {
    const Pose T_views_points =
        submap->submap().T_odom_submap.Inverse() * piece.submap->submap().T_odom_submap;
    if (!Meet(*submap, *piece.submap, T_views_points, options.max_range_m)) continue;
    for (const PreparedSubmap::View& view : submap->views()) {
      const Comparer comparer(view, T_views_points, options);
      size_t i = 0;
      for (const FreeSpaceMap::Column& column : piece.columns) {
        if (!comparer.Reaches(column)) {
          i += column.points.size();
          continue;
        }
        for (const SurfacePoint& point : column.points) {
          const int compared = comparer.Compare(point);
          scores[i].front += compared > 0;
          scores[i++].agree += compared < 0;
        }
      }
    }
  }
  return scores;
}

// Keeps the points that `keep(score)` says yes to, in order of the scores.
template <typename Keep>
void Filter(const std::vector<FreeSpaceScore>& scores, const Keep& keep,
            FreeSpaceMap::Piece* piece) {
  size_t i = 0;
  for (FreeSpaceMap::Column& column : piece->columns) {
    std::erase_if(column.points, [&](const SurfacePoint&) { return !keep(scores[i++]); });
  }
}

bool IsFleeting(const FreeSpaceScore& score) { return score.violation() > kMaxFleeting; }

// Boxes around points, by voxel: those that touch stand together.
class StandingThings {
 public:
  void Add(const Eigen::Vector3d& point) { boxes_[KeyOf(point)].Extend(point); }

  // True if all that hangs together with a point that was added is no larger than a person.
  bool IsSmall(const Eigen::Vector3d& point) {
    const uint64_t key = KeyOf(point);
    if (const auto known = small_.find(key); known != small_.end()) return known->second;
    std::vector<uint64_t> together = {key};
    absl::flat_hash_set<uint64_t> seen = {key};
    Box thing;
    bool small = true;
    for (size_t i = 0; i < together.size() && small; ++i) {
      const Box& box = boxes_[together[i]];
      thing.Extend(box);
      const Eigen::Vector3d size = thing.max - thing.min;
      small = size.z() < kSmallHighM && size.head<2>().maxCoeff() < kSmallWideM;
      ForNeighbors(box.min, [&](uint64_t neighbor) {
        if (const auto known = small_.find(neighbor); known != small_.end()) small &= known->second;
        if (boxes_.contains(neighbor) && seen.insert(neighbor).second) together.push_back(neighbor);
      });
    }
    for (const uint64_t part : together) small_[part] = small;
    return small;
  }

 private:
  static uint64_t KeyOf(const Eigen::Vector3d& p) {
    return VoxelKey(p.cast<float>(), 1 / kTogetherM);
  }
  template <typename Do>
  static void ForNeighbors(const Eigen::Vector3d& p, const Do& call) {
    for (int i = 0; i < 27; ++i) {
      const Eigen::Vector3i by(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      if (i != 13) call(KeyOf(p + kTogetherM * by.cast<double>()));
    }
  }

  absl::flat_hash_map<uint64_t, Box> boxes_;
  absl::flat_hash_map<uint64_t, bool> small_;  // Voxels that were asked about.
};

}  // namespace

FreeSpaceMap::FreeSpaceMap(const PreparedSubmaps& submaps, const Pose& T_level_odom,
                           const FreeSpaceOptions& options)
    : FreeSpaceMap(FreeSpaceMap(), submaps, T_level_odom, options) {}

FreeSpaceMap::FreeSpaceMap(FreeSpaceMap before, const PreparedSubmaps& submaps,
                           const Pose& T_level_odom, const FreeSpaceOptions& options)
    : FreeSpaceMap(std::move(before)) {
  const size_t first_new = pieces_.size();
  for (size_t i = first_new; i < submaps.size(); ++i) Add(submaps[i], T_level_odom, options);
  DropFleeting(first_new, options);
  DropSmall(first_new, T_level_odom);
}

void FreeSpaceMap::Add(const std::shared_ptr<const PreparedSubmap>& submap,
                       const Pose& T_level_odom, const FreeSpaceOptions& options) {
  const Pose& T_odom_submap = submap->submap().T_odom_submap;
  const Eigen::Matrix3f R = T_odom_submap.RotationMatrix().cast<float>();
  const Eigen::Vector3f t = T_odom_submap.translation().cast<float>();
  const Eigen::Vector3f up =
      ((T_level_odom * T_odom_submap).rotation().inverse() * Eigen::Vector3d::UnitZ())
          .cast<float>();
  const auto max_normal_z = static_cast<float>(options.max_abs_normal_z);
  auto piece = std::make_shared<Piece>();
  piece->submap = submap;
  absl::flat_hash_map<uint64_t, int> column_of;
  for (const SurfacePoint& point : submap->surface()) {
    if (std::abs(point.normal.dot(up)) > max_normal_z) continue;
    const Eigen::Vector3f& p = point.position;
    if (!taken_.insert(VoxelKey(R * p + t, 1 / kAskedSpacingM)).second) continue;
    const auto [entry, added] = column_of.try_emplace(VoxelKey(p, 1 / kAskedColumnM),
                                                      static_cast<int>(piece->columns.size()));
    if (added)
      piece->columns.push_back({((p / kAskedColumnM).array().floor() + 0.5f) * kAskedColumnM, {}});
    piece->columns[entry->second].points.push_back(point);
  }
  pieces_.push_back(std::move(piece));
}

void FreeSpaceMap::DropFleeting(size_t first_new, const FreeSpaceOptions& options) {
  std::vector<const PreparedSubmap*> all, fresh;
  for (size_t i = 0; i < pieces_.size(); ++i) {
    all.push_back(pieces_[i]->submap.get());
    if (i >= first_new) fresh.push_back(pieces_[i]->submap.get());
  }
  size_t views = 0;
  for (const PreparedSubmap* submap : all) views += submap->views().size();
  const int least = views < kEnoughViews ? 1 : kMinAgreeingViews;
  for (size_t i = 0; i < pieces_.size() && !fresh.empty(); ++i) {
    const bool is_new = i >= first_new;
    const std::vector<FreeSpaceScore> scores =
        AskOwnViews(*pieces_[i], is_new ? all : fresh, options);
    const auto keep = [&](const FreeSpaceScore& score) {
      return !IsFleeting(score) && (!is_new || score.agree >= least);
    };
    if (std::all_of(scores.begin(), scores.end(), keep)) continue;
    auto kept = std::make_shared<Piece>(*pieces_[i]);
    Filter(scores, keep, kept.get());
    pieces_[i] = std::move(kept);
  }
}

void FreeSpaceMap::DropSmall(size_t first_new, const Pose& T_level_odom) {
  const auto T_odom = [&](size_t i) { return pieces_[i]->submap->submap().T_odom_submap; };
  const auto is_near_new = [&](size_t i) {
    if (i >= first_new) return true;
    for (size_t k = first_new; k < pieces_.size(); ++k) {
      const Pose T_new_old = T_odom(k).Inverse() * T_odom(i);
      if (Meet(*pieces_[k]->submap, *pieces_[i]->submap, T_new_old, kSmallHighM)) return true;
    }
    return false;
  };
  StandingThings things;
  for (size_t i = 0; i < pieces_.size(); ++i) {
    if (!is_near_new(i)) continue;
    const Pose T_level_points = T_level_odom * T_odom(i);
    for (const Column& column : pieces_[i]->columns) {
      for (const SurfacePoint& point : column.points) {
        things.Add(T_level_points * point.position.cast<double>());
      }
    }
  }
  for (size_t i = first_new; i < pieces_.size(); ++i) {
    auto kept = std::make_shared<Piece>(*pieces_[i]);
    const Pose T_level_points = T_level_odom * T_odom(i);
    for (Column& column : kept->columns) {
      std::erase_if(column.points, [&](const SurfacePoint& point) {
        return things.IsSmall(T_level_points * point.position.cast<double>());
      });
    }
    pieces_[i] = std::move(kept);
  }
}

FreeSpaceScore ScoreFreeSpace(const FreeSpaceMap& a, const FreeSpaceMap& b, const MapPoses& poses,
                              const FreeSpaceOptions& options, size_t first_a, size_t first_b) {
  FreeSpaceScore score;
  for (size_t i = 0; i < a.pieces().size(); ++i) {
    for (size_t j = i < first_a ? first_b : 0; j < b.pieces().size(); ++j) {
      const FreeSpaceMap::Piece &in_a = *a.pieces()[i], &in_b = *b.pieces()[j];
      const Pose T_i_j = poses.a[i].Inverse() * poses.b[j];
      Compare(*in_a.submap, in_b, T_i_j, options, &score);
      Compare(*in_b.submap, in_a, T_i_j.Inverse(), options, &score);
    }
  }
  return score;
}

}  // namespace isthmus::matching
