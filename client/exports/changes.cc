#include "client/exports/changes.h"

#include <absl/strings/str_cat.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "core/earth/geojson.h"

namespace isthmus::exports {
namespace {

using Json = nlohmann::ordered_json;

double RoundedTo(double value, double parts) { return std::round(value * parts) / parts; }

Json NamesOf(const std::vector<RobotId>& robots) {
  Json names = Json::array();
  for (const RobotId& robot : robots) names.push_back(robot.value());
  return names;
}

Json PropertiesOf(const ChangedVolume& volume) {
  const auto metres = [](double m) { return RoundedTo(m, 1e3); };
  return {{"kind", volume.came ? "came" : "went"},
          {"length_m", metres(volume.size.x())},
          {"width_m", metres(volume.size.y())},
          {"height_m", metres(volume.size.z())},
          {"points", volume.points},
          {"probability", RoundedTo(volume.probability, 1e4)},
          {"seen_first", earth::UtcText(volume.seen_first_ns)},
          {"seen_last", earth::UtcText(volume.seen_last_ns)},
          {"missing", earth::UtcText(volume.missing_ns)},
          {"seen_by", NamesOf(volume.seen_by)},
          {"missed_by", NamesOf(volume.missed_by)}};
}

}  // namespace

std::array<Eigen::Vector3d, 4> FootOf(const ChangedVolume& volume) {
  const Eigen::Vector3d half = 0.5 * volume.size;
  const Pose& T = volume.T_map_box;
  return {T * Eigen::Vector3d(-half.x(), -half.y(), -half.z()),
          T * Eigen::Vector3d(half.x(), -half.y(), -half.z()),
          T * Eigen::Vector3d(half.x(), half.y(), -half.z()),
          T * Eigen::Vector3d(-half.x(), half.y(), -half.z())};
}

std::string FormatChangesPly(const ChangeList& changes) {
  size_t points = 0;
  for (const ChangedVolume& volume : changes.volumes) points += volume.places.size();
  std::string ply = absl::StrCat(
      "ply\nformat binary_little_endian 1.0\ncomment what came is green, what went is red\n",
      "element vertex ", points,
      "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
      "property uchar green\nproperty uchar blue\nproperty uint volume\nend_header\n");
  uint32_t number = 0;
  for (const ChangedVolume& volume : changes.volumes) {
    const uint8_t color[3] = {static_cast<uint8_t>(volume.came ? 30 : 220),
                              static_cast<uint8_t>(volume.came ? 160 : 40), 60};
    for (const Eigen::Vector3f& place : volume.places) {
      ply.append(reinterpret_cast<const char*>(place.data()), 3 * sizeof(float));
      ply.append(reinterpret_cast<const char*>(color), sizeof color);
      ply.append(reinterpret_cast<const char*>(&number), sizeof number);
    }
    ++number;
  }
  return ply;
}

std::string FormatChangesGeoJson(const ChangeList& changes, const earth::Site& site) {
  Json features = Json::array();
  for (const ChangedVolume& volume : changes.volumes) {
    Json ring = Json::array();
    for (const Eigen::Vector3d& corner : FootOf(volume)) {
      ring.push_back(earth::PositionOf(corner, site));
    }
    ring.push_back(ring.front());
    features.push_back(
        earth::FeatureOf(PropertiesOf(volume), "Polygon", Json::array({std::move(ring)})));
  }
  return earth::FormatFeatures(std::move(features));
}

}  // namespace isthmus::exports
