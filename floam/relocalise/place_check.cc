#include "floam/relocalise/place_check.h"

#include <algorithm>
#include <cmath>

#include "floam/match/limits.h"
#include "floam/relocalise/limits.h"

namespace isthmus::floam {
namespace {

LocalMapOptions MapOptions(const PlaceCheckOptions& options) {
  LocalMapOptions map;
  map.max_blocks = options.max_blocks;
  return map;
}

// A guess is worth little: the scan decides.
PosePrior AnywhereNear(const Pose& T_odom_sensor) { return {T_odom_sensor, Matrix6d::Identity()}; }

}  // namespace

PlaceCheck::PlaceCheck(const MatchOptions& matching, const PlaceCheckOptions& options)
    : matching_(matching),
      options_(options),
      surfaces_(ShapeKind::kPlane, MapOptions(options)),
      edges_(ShapeKind::kLine, MapOptions(options)) {}

void PlaceCheck::Clear() {
  surfaces_.Clear();
  filled_.clear();
}

void PlaceCheck::SetScan(const ScanFrame& frame, const ScanImage& image) {
  image_ = &image;
  features_.surfaces.clear();
  const auto radius2 = static_cast<float>(options_.radius_m * options_.radius_m);
  for (const TimedPoint& point : frame.features.surfaces) {
    if (point.position.squaredNorm() <= radius2) features_.surfaces.push_back(point);
  }
}

void PlaceCheck::FillAround(const MapMemory& memory, const Eigen::Vector3d& position) {
  if (surfaces_.block_count() > static_cast<size_t>(options_.max_blocks)) Clear();
  MapMemory::ForTilesAround(position.head<2>(), options_.radius_m + 2,
                            [&](MapMemory::TileIndex index) {
                              if (!filled_.insert(MapMemory::KeyOf(index)).second) return;
                              points_.clear();
                              memory.AppendPoints(index, &points_);
                              for (const MapMemory::SeenPoint& p : points_)
                                surfaces_.Insert(p.position.cast<double>());
                            });
}

PlaceMatch PlaceCheck::Check(const MapMemory& memory, const ScanPose& guess, bool is_rough,
                             bool with_walls) {
  FillAround(memory, guess.T_odom_sensor.translation());
  ScanPose start = guess;
  if (is_rough) {
    MatchOptions rough = matching_;
    rough.stride = kRoughStride;
    rough.kernel_start_m = options_.kernel_start_m;
    start = matcher_
                .Match(features_, guess, AnywhereNear(guess.T_odom_sensor), std::nullopt, rough,
                       &surfaces_, &edges_)
                .pose;
  }
  TwistPrior prior;
  prior.mean = start.twist;
  prior.sigma.setConstant(options_.twist_sigma);
  PlaceMatch place;
  place.match = matcher_.Match(features_, start, AnywhereNear(start.T_odom_sensor), prior,
                               matching_, &surfaces_, &edges_);
  place.share = static_cast<double>(place.match.used) / std::max(place.match.features, 1);
  if (with_walls && place.match.pose.T_odom_sensor.IsFinite())
    place.walls = Walls(memory, *image_, place.match.pose.T_odom_sensor);
  return place;
}

WallsSeen PlaceCheck::Walls(const MapMemory& memory, const ScanImage& image,
                            const Pose& T_map_sensor) {
  const Pose T_sensor_map = T_map_sensor.Inverse();
  const Eigen::Matrix3f R = T_sensor_map.RotationMatrix().cast<float>();
  const Eigen::Vector3f t = T_sensor_map.translation().cast<float>();
  WallsSeen walls;
  points_.clear();
  MapMemory::ForTilesAround(
      T_map_sensor.translation().head<2>(), kWallRangeM,
      [&](MapMemory::TileIndex index) { memory.AppendPoints(index, &points_); });
  for (size_t i = 0; i < points_.size(); i += kRoughStride) {
    if (!points_[i].on_wall) continue;
    const Eigen::Vector3f p = R * points_[i].position + t;
    if (p.squaredNorm() > kWallRangeM * kWallRangeM) continue;
    const ScanImage::Sight sight = image.SightOf(p);
    walls.onto += sight == ScanImage::Sight::kOnto;
    walls.through += sight == ScanImage::Sight::kThrough;
  }
  return walls;
}

}  // namespace isthmus::floam
