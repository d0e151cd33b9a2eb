#include "client/readers/packets/laser_geometry.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/geometry/angles.h"

namespace isthmus::readers {
namespace {

constexpr double kRadPerUnit = kRadPerDeg / 100;  // Math

// The walls of the two point calibration, metres, and the unit of focal distances: HDL-64E S2
// User's Manual.
constexpr double kFarWall = 25.04;       // Format
constexpr double kNearWallX = 2.4;       // Format
constexpr double kNearWallY = 1.93;      // Format
constexpr double kFocalRange = 13100.0;  // Format

// Added to a range beyond the far correction, for a target at that distance along an axis.
double NearCorrection(double far, double near, double along, double near_wall) {
  return (far - near) * (along - near_wall) / (kFarWall - near_wall) + near - far;
}

double Squared(double value) { return value * value; }

}  // namespace

Calibration MakeCalibration(std::string source, int lasers, const double* elevations_deg,
                            const double* azimuths_deg) {
  Calibration calibration;
  calibration.source = std::move(source);
  calibration.lasers.resize(static_cast<size_t>(lasers));
  for (size_t i = 0; i < calibration.lasers.size(); ++i) {
    if (elevations_deg != nullptr) calibration.lasers[i].elevation = elevations_deg[i] * kRadPerDeg;
    if (azimuths_deg != nullptr) calibration.lasers[i].rotation = -azimuths_deg[i] * kRadPerDeg;
  }
  return calibration;
}

LaserGeometry::LaserGeometry(const Calibration& calibration)
    : range_unit_m_(calibration.range_unit_m) {
  std::vector<size_t> order(calibration.lasers.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return calibration.lasers[a].elevation < calibration.lasers[b].elevation;
  });
  lasers_.resize(order.size());
  for (size_t ring = 0; ring < order.size(); ++ring) {
    const Laser& laser = calibration.lasers[order[ring]];
    Prepared& prepared = lasers_[order[ring]];
    prepared.laser = laser;
    prepared.sin_elevation = std::sin(laser.elevation);
    prepared.cos_elevation = std::cos(laser.elevation);
    prepared.rotation = std::fmod(laser.rotation / kRadPerUnit, kTurn);
    prepared.xy_shift = laser.vertical_offset * prepared.sin_elevation;
    prepared.z_shift = laser.vertical_offset * prepared.cos_elevation + laser.height;
    prepared.two_point = laser.two_point;
    prepared.focus = laser.focal_slope != 0;
    prepared.focal_offset = 256 * Squared(1 - laser.focal_distance / kFocalRange);
    prepared.ring = static_cast<uint16_t>(ring);
  }
  angles_.resize(kTurn);
  for (int i = 0; i < kTurn; ++i) {
    angles_[i] = {std::sin(i * kRadPerUnit), std::cos(i * kRadPerUnit)};
  }
}

LaserGeometry::Angle LaserGeometry::AngleOf(double azimuth) const {
  while (azimuth < 0) azimuth += kTurn;
  while (azimuth >= kTurn) azimuth -= kTurn;
  const int whole = std::min(static_cast<int>(azimuth), kTurn - 1);
  // Two terms of the series are exact to 1e-12 for the small rest.
  const double rest = (azimuth - whole) * kRadPerUnit;
  const double rest_cos = 1 - rest * rest / 2;
  const Angle& angle = angles_[whole];
  return {angle.sin * rest_cos + angle.cos * rest, angle.cos * rest_cos - angle.sin * rest};
}

LaserGeometry::Position LaserGeometry::Locate(size_t laser, double azimuth, uint16_t range,
                                              uint8_t reflectivity) const {
  const Prepared& prepared = lasers_[laser];
  const Laser& given = prepared.laser;
  const Angle angle = AngleOf(azimuth - prepared.rotation);
  const double distance = range * range_unit_m_ + given.range_far;
  double distance_x = distance, distance_y = distance;
  const auto along_ground = [&](double d) {
    return d * prepared.cos_elevation - prepared.xy_shift;
  };
  if (prepared.two_point) {
    const double ground = along_ground(distance);
    const double x = std::abs(ground * angle.sin - given.horizontal_offset * angle.cos);
    const double y = std::abs(ground * angle.cos + given.horizontal_offset * angle.sin);
    distance_x += NearCorrection(given.range_far, given.range_near_x, x, kNearWallX);
    distance_y += NearCorrection(given.range_far, given.range_near_y, y, kNearWallY);
  }
  double intensity = reflectivity;
  if (prepared.focus) {
    intensity +=
        given.focal_slope * std::abs(prepared.focal_offset - 256 * Squared(1 - range / 65535.0));
  }
  intensity = std::min(std::max(intensity, given.min_intensity), given.max_intensity);
  Position position;
  position.x = static_cast<float>(along_ground(distance_y) * angle.cos +
                                  given.horizontal_offset * angle.sin);
  position.y = static_cast<float>(given.horizontal_offset * angle.cos -
                                  along_ground(distance_x) * angle.sin);
  position.z = static_cast<float>(distance_y * prepared.sin_elevation + prepared.z_shift);
  position.intensity = static_cast<float>(intensity);
  position.ring = prepared.ring;
  return position;
}

}  // namespace isthmus::readers
