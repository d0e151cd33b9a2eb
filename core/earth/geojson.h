// The words of GeoJSON (RFC 7946) that all files of the map on the Earth share.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "core/earth/site.h"

namespace isthmus::earth {

// [longitude, latitude, altitude] of a point of the map frame, in degrees to a tenth of a
// millimetre and metres above the ellipsoid.
nlohmann::ordered_json PositionOf(const Eigen::Vector3d& map, const Site& site);

nlohmann::ordered_json FeatureOf(nlohmann::ordered_json properties, const std::string& geometry,
                                 nlohmann::ordered_json coordinates);

// A FeatureCollection, ending in a line's end.
std::string FormatFeatures(nlohmann::ordered_json features);

// RFC 3339, UTC, to the millisecond.
std::string UtcText(int64_t stamp_ns);

}  // namespace isthmus::earth
