// Changes of the map, for programs that show clouds and for maps on the web.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

#include "core/earth/site.h"
#include "core/records/changed_volumes.h"

namespace isthmus::exports {

// The four corners of its foot, seen from above, counter-clockwise; map frame, at the foot's
// height.
std::array<Eigen::Vector3d, 4> FootOf(const ChangedVolume& volume);

// PLY (binary, little endian) of the volumes' points, which must have been asked for: x y z
// (float), red green blue (uchar; what came is green, what went is red) and volume (uint, its place
// in the list).
std::string FormatChangesPly(const ChangeList& changes);

// GeoJSON (RFC 7946): a Polygon feature per volume around its foot with [longitude, latitude,
// altitude], degrees and metres above the ellipsoid, and the properties kind, length_m, width_m,
// height_m, points, probability, seen_first, seen_last, missing (RFC 3339, UTC), seen_by and
// missed_by.
std::string FormatChangesGeoJson(const ChangeList& changes, const earth::Site& site);

}  // namespace isthmus::exports
