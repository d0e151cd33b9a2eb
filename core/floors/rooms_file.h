// Rooms and doors as a file.
#pragma once

#include <string>

#include "core/floors/rooms.h"

namespace isthmus::floors {

// A FeatureCollection of GeoJSON (RFC 7946) with places [x, y] in metres of the map frame, which
// its member "frame" says. Rooms are Polygons with the properties kind ("room" or "corridor"), id
// (their numbers), area_m2 and inside, doors LineStrings with kind "door", width_m and rooms.
std::string FormatRooms(const Rooms& found);

}  // namespace isthmus::floors
