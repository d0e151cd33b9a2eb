#include "lab/bench/large_map/city.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isthmus::bench {
namespace {

constexpr double kSensorHeightM = 1.8;
constexpr int kLasers = 64;

// The distance at which a ray enters the box; infinity if it misses. It begins outside.
double EnterBox(const Eigen::Vector3d& from, const Eigen::Vector3d& direction, const Box& box) {
  double enter = 0, leave = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    double near = (box.min[axis] - from[axis]) / direction[axis];
    double far = (box.max[axis] - from[axis]) / direction[axis];
    if (near > far) std::swap(near, far);
    enter = std::max(enter, near);
    leave = std::min(leave, far);
  }
  return enter < leave ? enter : std::numeric_limits<double>::infinity();
}

}  // namespace

double City::HouseHeight(int x, int y) const {
  return 4 + 3 * ((static_cast<unsigned>(x) * 2654435761u ^ static_cast<unsigned>(y) * 40503u) % 7);
}

double City::Cast(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const {
  const double block = options_.block_m, half_street = options_.street_width_m / 2;
  double range = options_.range_m;
  if (direction.z() < 0) range = std::min(range, -from.z() / direction.z());
  // Block by block along the ray: streets lie on the lines between blocks.
  int last_x = 1 << 30, last_y = 1 << 30;
  for (double at = 0; at < range; at += block / 4) {
    const Eigen::Vector3d p = from + at * direction;
    const int x = static_cast<int>(std::floor(p.x() / block));
    const int y = static_cast<int>(std::floor(p.y() / block));
    if (x == last_x && y == last_y) continue;
    last_x = x;
    last_y = y;
    Box house;
    house.min = {x * block + half_street, y * block + half_street, -1};
    house.max = {(x + 1) * block - half_street, (y + 1) * block - half_street, HouseHeight(x, y)};
    range = std::min(range, EnterBox(from, direction, house));
  }
  return range;
}

Pose City::PoseAfter(double path_length_m, double lane_m) const {
  path_length_m = std::fmod(path_length_m, this->path_length_m());
  const int street = static_cast<int>(path_length_m / Edge());
  const double along = path_length_m - street * Edge();
  const bool back = street % 2 == 1;
  return Pose::FromXyzRpy(back ? Edge() - along : along,
                          street * options_.block_m + (back ? lane_m : -lane_m), kSensorHeightM, 0,
                          0, back ? std::numbers::pi : 0);
}

Submap City::Drive(double path_length_m, double lane_m, std::mt19937* rng) const {
  std::normal_distribution<double> noise(0, options_.noise_m);
  std::uniform_real_distribution<double> unit(0, 1);
  Submap submap;
  submap.T_odom_submap = PoseAfter(path_length_m, lane_m);
  const Pose T_submap_odom = submap.T_odom_submap.Inverse();
  submap.points.reserve(static_cast<size_t>(options_.keyframes) * options_.points);
  for (int k = 0; k < options_.keyframes; ++k) {
    const Pose T_submap_sensor = T_submap_odom * PoseAfter(path_length_m + k, lane_m);
    submap.keyframes.push_back({.T_submap_sensor = T_submap_sensor});
    const Pose T_odom_sensor = submap.T_odom_submap * T_submap_sensor;
    for (int i = 0; i < options_.points;) {
      const double azimuth = 2 * std::numbers::pi * unit(*rng);
      const double elevation =
          (-25 + 40. / kLasers * static_cast<double>((*rng)() % kLasers)) * std::numbers::pi / 180;
      const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth),
                                std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const Eigen::Vector3d direction = T_odom_sensor.RotationMatrix() * ray;
      const double range = Cast(T_odom_sensor.translation(), direction);
      if (range >= options_.range_m) continue;  // The sky.
      const Eigen::Vector3d p = T_submap_sensor * ((range + noise(*rng)) * ray).eval();
      submap.points.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()),
                               static_cast<float>(p.z()), static_cast<float>((*rng)() % 256),
                               static_cast<uint16_t>(k)});
      ++i;
    }
  }
  return submap;
}

}  // namespace isthmus::bench
