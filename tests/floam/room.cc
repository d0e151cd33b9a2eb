#include "tests/floam/room.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace isthmus::floam::testing {
namespace {

// The distances at which a ray enters and leaves a cuboid (slab method).
std::pair<double, double> Slabs(const Cuboid& box, const Eigen::Vector3d& origin,
                                const Eigen::Vector3d& direction) {
  double enter = -std::numeric_limits<double>::infinity();
  double leave = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (box.min[axis] - origin[axis]) / direction[axis];
    const double b = (box.max[axis] - origin[axis]) / direction[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return {enter, leave};
}

}  // namespace

double Room::Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  double nearest = Slabs(walls, origin, direction).second;
  for (const Cuboid& box : boxes) {
    const auto [enter, leave] = Slabs(box, origin, direction);
    if (enter > 0 && enter < leave) nearest = std::min(nearest, enter);
  }
  return nearest;
}

Room FurnishedRoom() {
  Room room;
  room.boxes = {
      {{-6.3, -4.3, -1.2}, {-5.7, -3.7, 3.8}}, {{5.7, -4.3, -1.2}, {6.3, -3.7, 3.8}},
      {{5.2, 4.1, -1.2}, {5.9, 4.8, 3.8}},     {{-10, 5.8, -1.2}, {-6, 7, 1.1}},
      {{7.5, -1.2, -1.2}, {10, 1.9, 0.4}},     {{-0.8, -0.6, -1.2}, {0.7, 0.8, 0.9}},
  };
  return room;
}

Scan MakeScan(const Room& room, const Motion& motion, const Sensor& sensor, int index) {
  Scan scan;
  scan.sequence = static_cast<uint64_t>(index) + 1;
  const double begin_s = index * sensor.period_s;
  scan.end_stamp_ns = 1'000'000'000 + std::llround((begin_s + sensor.period_s) * 1e9);
  scan.has_ring = scan.has_time = true;
  std::mt19937 random(static_cast<unsigned>(index) + 17);
  std::normal_distribution<double> noise(0, 1);
  for (int column = 0; column < sensor.columns; ++column) {
    const double fraction = static_cast<double>(column) / sensor.columns;
    const Pose T_world_sensor = motion(begin_s + fraction * sensor.period_s);
    const double azimuth = std::numbers::pi * (1 - 2 * fraction);
    for (int ring = 0; ring < sensor.rings; ++ring) {
      const double elevation = sensor.lowest_rad + (sensor.highest_rad - sensor.lowest_rad) * ring /
                                                       std::max(1, sensor.rings - 1);
      const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                      std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const double range =
          room.Cast(T_world_sensor.translation(), T_world_sensor.rotation() * direction) +
          sensor.noise_m * noise(random);
      const Eigen::Vector3f p = (range * direction).cast<float>();
      scan.points.push_back({p.x(), p.y(), p.z(), 10,
                             static_cast<float>((fraction - 1) * sensor.period_s),
                             static_cast<uint16_t>(ring)});
    }
  }
  return scan;
}

Eigen::Vector3d Raster(int k, int points, int) {
  const int columns = static_cast<int>(std::sqrt(points / 0.75)), row = k / columns;
  const double azimuth = (60 - 120.0 * (k % columns) / (columns - 1)) * std::numbers::pi / 180;
  const double elevation = (45 - 90.0 * row * columns / points) * std::numbers::pi / 180;
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

Eigen::Vector3d Scattered(int k, int points, int index) {
  const double i = k + static_cast<double>(points) * index;
  const double azimuth = 2 * std::numbers::pi * std::fmod(0.7548776662466927 * i, 1);
  const double elevation =
      (-7 + 59 * std::fmod(0.5698402909980532 * i, 1)) * std::numbers::pi / 180;
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

Scan MakeScanWithoutRings(const Room& room, const Motion& motion, const Pattern& pattern,
                          int points, int index, double noise_m) {
  const double period_s = Sensor().period_s;
  Scan scan;
  scan.sequence = static_cast<uint64_t>(index) + 1;
  scan.end_stamp_ns = 1'000'000'000 + std::llround((index + 1) * period_s * 1e9);
  scan.has_time = true;
  std::mt19937 random(static_cast<unsigned>(index) + 17);
  std::normal_distribution<double> noise(0, 1);
  for (int k = 0; k < points; ++k) {
    const double fraction = static_cast<double>(k) / points;
    const Pose T_world_sensor = motion((index + fraction) * period_s);
    const Eigen::Vector3d direction = pattern(k, points, index);
    const double range =
        room.Cast(T_world_sensor.translation(), T_world_sensor.rotation() * direction) +
        noise_m * noise(random);
    const Eigen::Vector3f p = (range * direction).cast<float>();
    scan.points.push_back(
        {p.x(), p.y(), p.z(), 10, static_cast<float>((fraction - 1) * period_s), 0});
  }
  return scan;
}

Pose EndPose(const Motion& motion, const Sensor& sensor, int index) {
  return motion((index + 1) * sensor.period_s);
}

Motion Loop(double speed) {
  return [speed](double time_s) {
    const double moving = std::max(0.0, time_s - 0.5);
    const double distance = speed * (moving < 1 ? 0.5 * moving * moving : moving - 0.5);
    const double angle = distance / 3.4;  // About the mean radius.
    const Eigen::Vector3d position(4.2 * std::cos(angle), 2.6 * std::sin(angle), 0);
    const double heading = std::atan2(2.6 * std::cos(angle), -4.2 * std::sin(angle));
    return Pose::FromXyzRpy(position.x(), position.y(), position.z(), 0, 0, heading);
  };
}

}  // namespace isthmus::floam::testing
