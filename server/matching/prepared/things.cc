#include "server/matching/prepared/things.h"

#include <absl/container/flat_hash_map.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "server/matching/prepared/free_space.h"
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

// The points that were seen between kThingsFromM and kThingsToM over the ground.
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

// The things in squares that are not in `taken`, to which it adds the squares.
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

}  // namespace

class Things::Target {
 public:
  Target(const Piece& piece, const Pose& T_piece_points)
      : piece_(piece),
        R_(T_piece_points.RotationMatrix().cast<float>()),
        t_(T_piece_points.translation().cast<float>()) {
    for (const PreparedSubmap::View& view : piece.submap->views()) {
      const Pose T_sensor_points = view.T_submap_sensor.Inverse() * T_piece_points;
      eyes_.push_back({&view.image, T_sensor_points.RotationMatrix().cast<float>(),
                       T_sensor_points.translation().cast<float>()});
    }
  }

  bool Has(const Eigen::Vector3f& point) const {
    return piece_.low.Nearest(piece_.flatten * (R_ * point + t_), kOnThingM).index >= 0;
  }

  FreeSpaceScore LookAt(const Eigen::Vector3f& point) const {
    FreeSpaceScore score;
    const PreparedSubmap& submap = *piece_.submap;
    const Eigen::Vector3f p = R_ * point + t_;
    if ((p.cast<double>() - submap.center()).norm() > submap.radius_m()) return score;
    for (const Eye& eye : eyes_) {
      const Eigen::Vector3f seen_at = eye.R * point + eye.t;
      const float range = seen_at.norm();
      RangeImage::Interval seen;
      if (range < kMinComparedM || range > kThingsSeenM || !eye.image->At(seen_at, &seen)) continue;
      const int compared = seen.Compare(range, kThroughM + kThroughPerM * range);
      score.front += compared > 0;
      score.agree += compared < 0;
    }
    return score;
  }

 private:
  struct Eye {
    const RangeImage* image;
    Eigen::Matrix3f R;  // To the sensor's frame.
    Eigen::Vector3f t;
  };
  const Piece& piece_;
  Eigen::Matrix3f R_;  // To the piece's frame.
  Eigen::Vector3f t_;
  std::vector<Eye> eyes_;
};

std::vector<Things::Target> Things::TargetsOf(const PreparedSubmap& submap,
                                              const Pose& T_common_submap,
                                              const std::vector<Pose>& T_common_pieces,
                                              size_t first) const {
  std::vector<Target> targets;
  for (size_t i = first; i < pieces_.size(); ++i) {
    const Pose T_piece_submap = T_common_pieces[i].Inverse() * T_common_submap;
    if (Meet(*pieces_[i]->submap, submap, T_piece_submap)) {
      targets.emplace_back(*pieces_[i], T_piece_submap);
    }
  }
  return targets;
}

void Things::DropFleeting(size_t first_new) {
  std::vector<Pose> T_odom;
  for (const auto& piece : pieces_) T_odom.push_back(piece->submap->submap().T_odom_submap);
  for (size_t k = 0; k < pieces_.size(); ++k) {
    const bool is_new = k >= first_new;
    const std::vector<Target> targets =
        TargetsOf(*pieces_[k]->submap, T_odom[k], T_odom, is_new ? 0 : first_new);
    if (targets.empty()) continue;
    const auto is_fleeting = [&](const Eigen::Vector3f& point) {
      FreeSpaceScore score;
      for (const Target& target : targets) score += target.LookAt(point);
      return score.violation() > kMaxFleeting || (is_new && score.agree == 0);
    };
    auto kept = std::make_shared<Piece>(*pieces_[k]);
    for (Thing& thing : kept->things) std::erase_if(thing, is_fleeting);
    std::erase_if(kept->things,
                  [](const Thing& thing) { return thing.size() < kLeastThingPoints; });
    pieces_[k] = std::move(kept);
  }
}

Things::Things(Things before, const SessionMap& map, const PreparedSubmaps& submaps,
               const Pose& T_level_odom)
    : Things(std::move(before)) {
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
    pieces_.push_back(std::make_shared<const Piece>(
        Piece{submaps[k], FindThings(low[k - first_new], storey_of(k), plan_, &taken_), flatten,
              KdTree(points)}));
  }
  if (first_new < pieces_.size()) DropFleeting(first_new);
}

ThingAgreement Things::In(const Things& other, size_t k, const Pose& T_common_submap,
                          const std::vector<Pose>& T_common_other) const {
  const Piece& piece = *pieces_[k];
  const std::vector<Target> targets =
      other.TargetsOf(*piece.submap, T_common_submap, T_common_other, 0);
  const auto is_there = [&](const Eigen::Vector3f& point) {
    return std::ranges::any_of(targets, [&](const Target& target) { return target.Has(point); });
  };
  const auto is_looked_through = [&](const Eigen::Vector3f& point) {
    return std::ranges::any_of(
        targets, [&](const Target& target) { return target.LookAt(point).front > 0; });
  };
  ThingAgreement sum;
  for (const Thing& thing : piece.things) {
    int64_t there = 0, through = 0;
    for (const Eigen::Vector3f& point : thing) {
      if (is_there(point)) {
        ++there;
      } else {
        through += is_looked_through(point);
      }
    }
    const auto asked = static_cast<double>(thing.size());
    if (static_cast<double>(there + through) < kLeastThingSeen * asked) continue;
    ++(there > through ? sum.there : sum.gone);
  }
  return sum;
}

}  // namespace isthmus::matching
