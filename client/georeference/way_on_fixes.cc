#include "client/georeference/way_on_fixes.h"

#include <Eigen/Geometry>
#include <cmath>

#include "client/georeference/limits.h"

namespace isthmus::georeference {
namespace {

// A place in both frames, and how far it may miss without being odd.
struct Pair {
  Eigen::Vector2d level, map;
  double scale_m;
};

std::vector<Pair> PairsOf(const std::vector<AntennaPlace>& places, const Eigen::Vector3d& antenna) {
  std::vector<Pair> pairs;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const AntennaPlace& place : places) {
    pairs.push_back({(place.T_level_sensor * antenna).head<2>(), place.in_map.head<2>(), 0});
    middle += pairs.back().level / static_cast<double>(places.size());
  }
  for (size_t i = 0; i < pairs.size(); ++i) {
    pairs[i].scale_m =
        std::hypot(places[i].sigma_xy_m, kWayDrift * (pairs[i].level - middle).norm());
  }
  return pairs;
}

double MissOf(const WayOnFixes& way, const Pair& pair) {
  return (pair.map - way.shift - Eigen::Rotation2Dd(way.turn_rad) * pair.level).norm();
}

// Weighted least squares.
WayOnFixes Solve(const std::vector<Pair>& pairs, const std::vector<double>& weights) {
  double weight = 0;
  Eigen::Vector2d mean_level = Eigen::Vector2d::Zero(), mean_map = Eigen::Vector2d::Zero();
  for (size_t i = 0; i < pairs.size(); ++i) {
    weight += weights[i];
    mean_level += weights[i] * pairs[i].level;
    mean_map += weights[i] * pairs[i].map;
  }
  mean_level /= weight;
  mean_map /= weight;
  double along = 0, across = 0, spread = 0;
  for (size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Vector2d a = pairs[i].level - mean_level, b = pairs[i].map - mean_map;
    along += weights[i] * a.dot(b);
    across += weights[i] * (a.x() * b.y() - a.y() * b.x());
    spread += weights[i] * a.squaredNorm();
  }
  WayOnFixes way;
  if (spread > 0) {
    // The information on the turn is the spread: a place r from the middle is moved r by a radian.
    way.turn_rad = std::atan2(across, along);
    way.sigma_rad = std::hypot(1 / std::sqrt(spread), kHeadingDriftRad);
  }
  way.shift = mean_map - Eigen::Rotation2Dd(way.turn_rad) * mean_level;
  return way;
}

}  // namespace

WayOnFixes LayOnFixes(const std::vector<AntennaPlace>& places, const Eigen::Vector3d& antenna) {
  if (places.empty()) return {};
  const std::vector<Pair> pairs = PairsOf(places, antenna);
  std::vector<double> weights(pairs.size());
  for (size_t i = 0; i < pairs.size(); ++i) weights[i] = 1 / std::pow(pairs[i].scale_m, 2);
  WayOnFixes way = Solve(pairs, weights);
  if (pairs.size() >= kLeastPlaces) {
    for (int round = 0; round < kWayRounds; ++round) {
      for (size_t i = 0; i < pairs.size(); ++i) {
        const double odd = MissOf(way, pairs[i]) / (kOddSigmas * pairs[i].scale_m);
        weights[i] = 1 / (std::pow(pairs[i].scale_m, 2) * (1 + odd * odd));
      }
      way = Solve(pairs, weights);
    }
  }
  for (const Pair& pair : pairs) {
    way.is_wild.push_back(pairs.size() >= kLeastPlaces &&
                          MissOf(way, pair) > kWildSigmas * pair.scale_m);
  }
  return way;
}

}  // namespace isthmus::georeference
