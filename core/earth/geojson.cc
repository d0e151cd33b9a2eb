#include "core/earth/geojson.h"

#include <absl/time/time.h>

#include <cmath>
#include <utility>

namespace isthmus::earth {
namespace {

using nlohmann::ordered_json;

// To a part of one: a billionth of a degree is a tenth of a millimetre.
double Rounded(double value, double parts) { return std::round(value * parts) / parts; }

}  // namespace

ordered_json PositionOf(const Eigen::Vector3d& map, const Site& site) {
  const Geodetic place = site.ToGeodetic(map);
  return {Rounded(place.longitude_deg, 1e9), Rounded(place.latitude_deg, 1e9),
          Rounded(place.altitude_m, 1e4)};
}

ordered_json FeatureOf(ordered_json properties, const std::string& geometry,
                       ordered_json coordinates) {
  return {{"type", "Feature"},
          {"properties", std::move(properties)},
          {"geometry", {{"type", geometry}, {"coordinates", std::move(coordinates)}}}};
}

std::string FormatFeatures(ordered_json features) {
  return ordered_json{{"type", "FeatureCollection"}, {"features", std::move(features)}}.dump() +
         "\n";
}

std::string UtcText(int64_t stamp_ns) {
  return absl::FormatTime("%Y-%m-%dT%H:%M:%E3SZ", absl::FromUnixNanos(stamp_ns),
                          absl::UTCTimeZone());
}

}  // namespace isthmus::earth
