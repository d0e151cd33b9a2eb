// Robots' ways over the Earth, for maps on the web and for globes.
#pragma once

#include <string>
#include <vector>

#include "core/earth/site.h"
#include "core/map/track.h"

namespace isthmus::earth {

// GeoJSON (RFC 7946): a LineString feature per track with [longitude, latitude, altitude], degrees
// and metres above the ellipsoid, and the properties robot, session, begin and end (RFC 3339, UTC).
// A track of one pose is a Point; one of none is left out.
std::string FormatGeoJson(const std::vector<Track>& tracks, const Site& site);

// KML 2.3 (OGC 12-007r2): a Placemark per track, with a LineString of absolute altitude and a
// TimeSpan.
std::string FormatKml(const std::vector<Track>& tracks, const Site& site);

}  // namespace isthmus::earth
