#include "server/matching/prepared/things.h"

#include <absl/container/flat_hash_map.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "server/matching/prepared/limits.h"
#include "server/matching/registration/voxel_key.h"
#include "server/matching/search/ground_grid.h"

namespace isthmus::matching {
namespace {

struct LowPoint {
  Eigen::Vector3f in_submap;
  Eigen::Vector2f at;  // In the level frame.
  float height_m = 0;  // Over the ground.
};

// A point of each voxel that kLeastSeen keyframes saw: what fewer saw is dust, or walked on.
std::vector<Eigen::Vector3f> SeenOften(const Submap& submap) {
  struct Voxel {
    int seen = 0;
    uint16_t keyframe = 0;  // The last.
  };
  std::vector<Eigen::Vector3f> points, sensors;
  for (const Keyframe& keyframe : submap.keyframes) {
    sensors.push_back(keyframe.T_submap_sensor.translation().cast<float>());
  }
  absl::flat_hash_map<uint64_t, Voxel> voxels;
  for (const SubmapPoint& point : submap.points) {
    const Eigen::Vector3f p = point.Position();
    if (point.keyframe >= sensors.size()) continue;
    if (!((p - sensors[point.keyframe]).norm() < kThingsSeenM)) continue;  // So that NaN fails too.
    Voxel& voxel = voxels[VoxelKey(p, 1 / kThingVoxelM)];
    if (voxel.seen > 0 && voxel.keyframe == point.keyframe) continue;
    voxel.keyframe = point.keyframe;
    if (++voxel.seen == kLeastSeen) points.push_back(p);
  }
  return points;
}

// What was seen between kThingsFromM and kThingsToM over the ground.
std::vector<LowPoint> LowPoints(const Submap& submap, const PreparedSubmap& prepared,
                                const Pose& T_level_submap) {
  const Eigen::Matrix3f R = T_level_submap.RotationMatrix().cast<float>();
  const Eigen::Vector3f t = T_level_submap.translation().cast<float>();
  std::vector<SurfacePoint> surface = prepared.surface();
  for (SurfacePoint& point : surface) {
    point.position = R * point.position + t;
    point.normal = R * point.normal;
  }
  const GroundGrid ground(surface, kThingsGroundCellM);
  std::vector<LowPoint> low;
  for (const Eigen::Vector3f& point : SeenOften(submap)) {
    const Eigen::Vector3f p = R * point + t;
    const float height = p.z() - ground.Height(p.x(), p.y());
    if (height > kThingsFromM && height < kThingsToM) low.push_back({point, p.head<2>(), height});
  }
  return low;
}

// Those of the squares that are in none of `taken`, which they are added to.
std::vector<std::vector<Eigen::Vector3f>> FindThings(const std::vector<LowPoint>& low, int storey,
                                                     const LowPlan& plan,
                                                     absl::flat_hash_set<uint64_t>* taken) {
  absl::flat_hash_map<uint64_t, std::vector<Eigen::Vector3f>> squares;
  absl::flat_hash_map<uint64_t, bool> at_wall;  // By cell of the plan.
  std::vector<uint64_t> order;
  const float z = static_cast<float>(storey) + 0.5f;
  for (const LowPoint& point : low) {
    const Eigen::Vector2f& at = point.at;
    const uint64_t cell = VoxelKey({at.x(), at.y(), 0}, 1 / kThingVoxelM);
    const auto [known, is_new] = at_wall.try_emplace(cell, false);
    if (is_new) known->second = plan.IsAtWall(at, storey);
    if (known->second) continue;
    const uint64_t square = VoxelKey({at.x(), at.y(), z * kThingM}, 1 / kThingM);
    std::vector<Eigen::Vector3f>& points = squares[square];
    if (points.empty()) order.push_back(square);
    points.push_back(point.in_submap);
  }
  std::vector<std::vector<Eigen::Vector3f>> things;
  for (const uint64_t square : order) {
    const std::vector<Eigen::Vector3f>& points = squares[square];
    if (points.size() < kLeastThingPoints || !taken->insert(square).second) continue;
    const size_t stride = (points.size() - 1) / kThingPoints + 1;
    std::vector<Eigen::Vector3f>& thing = things.emplace_back();
    for (size_t i = 0; i < points.size(); i += stride) thing.push_back(points[i]);
  }
  return things;
}

// Heights count less than places on the floor: of sparse rings none meets the point of another.
Eigen::Matrix3f Flatten(const Pose& T_level_submap) {
  const Eigen::Vector3f up =
      (T_level_submap.rotation().inverse() * Eigen::Vector3d::UnitZ()).cast<float>();
  return Eigen::Matrix3f::Identity() - (1 - kThingHeightWeight) * up * up.transpose();
}

struct Target {
  const PreparedSubmap* submap;
  const KdTree* low;
  const Eigen::Matrix3f* flatten;
  Eigen::Matrix3f R;  // To the target's frame.
  Eigen::Vector3f t;
};

// -1: behind it is what was measured, it was looked through; +1: it is there; 0: no say.
int Look(const PreparedSubmap::View& view, const Eigen::Vector3f& p_submap) {
  const Eigen::Vector3f p =
      (view.T_submap_sensor.Inverse() * p_submap.cast<double>()).cast<float>();
  const float range = p.norm();
  RangeImage::Interval seen;
  if (range < kMinComparedM || range > kThingsSeenM || !view.image.At(p, &seen)) return 0;
  const float margin = kThroughM + kThroughPerM * range;
  if (range + margin < seen.shortest) return -1;
  return range < seen.shortest + margin || std::abs(range - seen.longest) < margin ? 1 : 0;
}

bool IsOn(const std::vector<Target>& targets, const Eigen::Vector3f& point) {
  return std::any_of(targets.begin(), targets.end(), [&](const Target& target) {
    return target.low->Nearest(*target.flatten * (target.R * point + target.t), kOnThingM).index >=
           0;
  });
}

bool IsLookedThrough(const std::vector<Target>& targets, const Eigen::Vector3f& point) {
  return std::any_of(targets.begin(), targets.end(), [&](const Target& target) {
    const Eigen::Vector3f p = target.R * point + target.t;
    const PreparedSubmap& submap = *target.submap;
    if ((p.cast<double>() - submap.center()).norm() > submap.radius_m()) return false;
    const auto& views = submap.views();
    return std::any_of(views.begin(), views.end(),
                       [&](const PreparedSubmap::View& view) { return Look(view, p) < 0; });
  });
}

}  // namespace

bool Things::IsSeenFrom(size_t k, size_t first) const {
  const PreparedSubmap& seen = *pieces_[k]->submap;
  return std::any_of(pieces_.begin() + static_cast<std::ptrdiff_t>(first), pieces_.end(),
                     [&](const auto& piece) {
                       const PreparedSubmap& seer = *piece->submap;
                       const Pose T_seer_seen =
                           seer.submap().T_odom_submap.Inverse() * seen.submap().T_odom_submap;
                       const double apart = (T_seer_seen * seen.center() - seer.center()).norm();
                       return apart < seer.radius_m() + seen.radius_m();
                     });
}

Things::Piece Things::WithoutFleeting(Piece piece, size_t first) const {
  const Pose& T_odom_submap = piece.submap->submap().T_odom_submap;
  const int least = first > 0 ? 0 : 1;
  const auto is_fleeting = [&](const Eigen::Vector3f& point) {
    int there = 0, through = 0;
    for (size_t i = first; i < pieces_.size(); ++i) {
      const PreparedSubmap& seer = *pieces_[i]->submap;
      const Pose T_seer_submap = seer.submap().T_odom_submap.Inverse() * T_odom_submap;
      const Eigen::Vector3d p = T_seer_submap * point.cast<double>();
      if ((p - seer.center()).norm() > seer.radius_m()) continue;
      for (const PreparedSubmap::View& view : seer.views()) {
        const int look = Look(view, p.cast<float>());
        there += look > 0;
        through += look < 0;
      }
    }
    return there < least ||
           static_cast<float>(through) > kMaxFleeting * static_cast<float>(there + through);
  };
  for (Thing& thing : piece.things) std::erase_if(thing.points, is_fleeting);
  std::erase_if(piece.things,
                [](const Thing& thing) { return thing.points.size() < kLeastThingPoints; });
  return piece;
}

Things::Things(const Things& before, const SessionMap& map, const PreparedSubmaps& submaps,
               const Pose& T_level_odom)
    : Things(before) {
  const size_t first_new = pieces_.size();
  std::vector<std::vector<LowPoint>> low;
  const auto T_level = [&](size_t k) { return T_level_odom * submaps[k]->submap().T_odom_submap; };
  const auto storey_of = [&](size_t k) {
    return static_cast<int>(std::round(T_level(k).translation().z() / kThingsStoreyM));
  };
  for (size_t k = first_new; k < submaps.size(); ++k) {
    low.push_back(LowPoints(*map.Whole(k), *submaps[k], T_level(k)));
    for (const LowPoint& point : low.back()) plan_.Add(point.at, storey_of(k), point.height_m);
  }
  for (size_t k = first_new; k < submaps.size(); ++k) {
    const Eigen::Matrix3f flatten = Flatten(T_level(k));
    std::vector<Eigen::Vector3f> points;
    for (const LowPoint& point : low[k - first_new]) points.push_back(flatten * point.in_submap);
    auto piece = std::make_shared<Piece>(Piece{submaps[k], {}, flatten, KdTree(points)});
    for (auto& thing : FindThings(low[k - first_new], storey_of(k), plan_, &taken_)) {
      piece->things.push_back({std::move(thing)});
    }
    pieces_.push_back(std::move(piece));
  }
  if (first_new == pieces_.size()) return;
  for (size_t k = 0; k < pieces_.size(); ++k) {
    const size_t first = k < first_new ? first_new : 0;
    if (IsSeenFrom(k, first)) {
      pieces_[k] = std::make_shared<const Piece>(WithoutFleeting(*pieces_[k], first));
    }
  }
}

ThingAgreement Things::In(const Things& other, size_t k, const Pose& T_common_submap,
                          const std::vector<Pose>& T_common_other) const {
  const Piece& piece = *pieces_[k];
  std::vector<Target> targets;
  for (size_t i = 0; i < other.pieces_.size(); ++i) {
    const PreparedSubmap& submap = *other.pieces_[i]->submap;
    const Pose T = T_common_other[i].Inverse() * T_common_submap;
    const double apart = (T * piece.submap->center() - submap.center()).norm();
    if (apart > piece.submap->radius_m() + submap.radius_m()) continue;
    targets.push_back({&submap, &other.pieces_[i]->low, &other.pieces_[i]->flatten,
                       T.RotationMatrix().cast<float>(), T.translation().cast<float>()});
  }
  ThingAgreement sum;
  for (const Thing& thing : piece.things) {
    int64_t on = 0, through = 0;
    for (const Eigen::Vector3f& point : thing.points) {
      const bool is_on = IsOn(targets, point);
      on += is_on;
      through += !is_on && IsLookedThrough(targets, point);
    }
    const auto asked = static_cast<double>(thing.points.size());
    if (static_cast<double>(on + through) < kLeastThingSeen * asked) continue;
    ++(on > through ? sum.there : sum.gone);
  }
  return sum;
}

}  // namespace isthmus::matching
