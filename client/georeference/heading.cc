#include "client/georeference/heading.h"

#include <cmath>

#include "client/georeference/limits.h"

namespace isthmus::georeference {

Heading HeadingOf(const std::vector<AntennaPlace>& places, const Eigen::Vector3d& antenna) {
  double weight = 0;
  Eigen::Vector2d mean_level = Eigen::Vector2d::Zero(), mean_map = Eigen::Vector2d::Zero();
  const auto in_level = [&antenna](const AntennaPlace& place) -> Eigen::Vector2d {
    return (place.T_level_sensor * antenna).head<2>();
  };
  for (const AntennaPlace& place : places) {
    const double w = 1 / (place.sigma_xy_m * place.sigma_xy_m);
    weight += w;
    mean_level += w * in_level(place);
    mean_map += w * place.in_map.head<2>();
  }
  if (weight == 0) return {};
  mean_level /= weight;
  mean_map /= weight;
  double along = 0, across = 0, spread = 0;
  for (const AntennaPlace& place : places) {
    const double w = 1 / (place.sigma_xy_m * place.sigma_xy_m);
    const Eigen::Vector2d a = in_level(place) - mean_level;
    const Eigen::Vector2d b = place.in_map.head<2>() - mean_map;
    along += w * a.dot(b);
    across += w * (a.x() * b.y() - a.y() * b.x());
    spread += w * a.squaredNorm();
  }
  if (!(spread > 0)) return {};
  // The information on the turn is the spread: a place r from the middle is moved r by a radian.
  return {std::atan2(across, along), std::hypot(1 / std::sqrt(spread), kHeadingDriftRad)};
}

}  // namespace isthmus::georeference
