#include "core/floors/rooms_file.h"

#include <cmath>
#include <utility>

#include "core/earth/geojson.h"

namespace isthmus::floors {
namespace {

using nlohmann::ordered_json;

double Rounded(double value) { return std::round(value * 1e3) / 1e3; }

ordered_json PlaceOf(const Eigen::Vector2d& map) { return {Rounded(map.x()), Rounded(map.y())}; }

// The first place again at the end.
ordered_json RingOf(const Outline& outline) {
  ordered_json ring = ordered_json::array();
  for (const Eigen::Vector2d& corner : outline) ring.push_back(PlaceOf(corner));
  if (!outline.empty()) ring.push_back(PlaceOf(outline.front()));
  return ring;
}

ordered_json FeatureOfRoom(const Room& room, size_t number) {
  ordered_json rings = {RingOf(room.outline)};
  for (const Outline& hole : room.holes) rings.push_back(RingOf(hole));
  return earth::FeatureOf({{"kind", room.is_corridor ? "corridor" : "room"},
                           {"id", number},
                           {"area_m2", Rounded(room.area_m2)},
                           {"inside", PlaceOf(room.inside)}},
                          "Polygon", std::move(rings));
}

ordered_json FeatureOfDoor(const Door& door) {
  ordered_json line = ordered_json::array();
  for (const Eigen::Vector2d& end : door.ends) line.push_back(PlaceOf(end));
  return earth::FeatureOf(
      {{"kind", "door"}, {"width_m", Rounded(door.width_m)}, {"rooms", door.rooms}}, "LineString",
      std::move(line));
}

}  // namespace

std::string FormatRooms(const Rooms& found) {
  ordered_json features = ordered_json::array();
  for (size_t i = 0; i < found.rooms.size(); ++i) {
    features.push_back(FeatureOfRoom(found.rooms[i], i));
  }
  for (const Door& door : found.doors) features.push_back(FeatureOfDoor(door));
  const ordered_json file = {
      {"type", "FeatureCollection"}, {"frame", "map"}, {"features", std::move(features)}};
  return file.dump() + "\n";
}

}  // namespace isthmus::floors
