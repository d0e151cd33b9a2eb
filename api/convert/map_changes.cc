#include "api/convert/map_changes.h"

#include "api/convert/geometry.h"
#include "api/convert/graph.h"
#include "api/convert/localisation.h"

namespace isthmus::convert {

v1::TileId ToMessage(const TileId& id) {
  v1::TileId message;
  message.set_component(id.component);
  message.set_level(id.level);
  message.set_x(id.x);
  message.set_y(id.y);
  return message;
}

TileId FromMessage(const v1::TileId& id) { return {id.component(), id.level(), id.x(), id.y()}; }

v1::TileInfo ToMessage(const TileInfo& info) {
  v1::TileInfo message;
  *message.mutable_id() = ToMessage(info.id);
  message.set_version(info.version);
  message.set_revision(info.revision);
  message.set_points(info.points);
  if (!info.bounds.empty()) *message.mutable_bounds() = ToMessage(info.bounds);
  return message;
}

TileInfo FromMessage(const v1::TileInfo& info) {
  TileInfo record;
  record.id = FromMessage(info.id());
  record.version = info.version();
  record.revision = info.revision();
  record.points = info.points();
  if (info.has_bounds()) record.bounds = FromMessage(info.bounds());
  return record;
}

v1::SubmapPlace ToMessage(const SubmapPlace& place) {
  v1::SubmapPlace message;
  message.set_session(place.submap.session.value());
  message.set_index(place.submap.index);
  message.set_robot(place.robot.value());
  if (!place.component) return message;
  message.set_component(*place.component);
  *message.mutable_t_map_submap() = ToMessage(place.T_map_submap);
  return message;
}

SubmapPlace FromMessage(const v1::SubmapPlace& place) {
  SubmapPlace record;
  record.submap = {SessionId(place.session()), place.index()};
  record.robot = RobotId(place.robot());
  if (place.has_component()) record.component = place.component();
  record.T_map_submap = FromMessage(place.t_map_submap());
  return record;
}

v1::RobotPlace ToMessage(const RobotPlace& place) {
  v1::RobotPlace message;
  message.set_robot(place.robot.value());
  message.set_session(place.session.value());
  if (place.component) {
    message.set_component(*place.component);
    *message.mutable_t_map_sensor() = ToMessage(place.T_map_sensor);
  }
  message.set_stamp_ns(place.stamp_ns);
  message.set_lag_ms(place.lag_ms);
  if (place.localising) *message.mutable_localising() = ToMessage(*place.localising);
  return message;
}

RobotPlace FromMessage(const v1::RobotPlace& place) {
  RobotPlace record;
  record.robot = RobotId(place.robot());
  record.session = SessionId(place.session());
  if (place.has_component()) record.component = place.component();
  record.T_map_sensor = FromMessage(place.t_map_sensor());
  record.stamp_ns = place.stamp_ns();
  record.lag_ms = place.lag_ms();
  if (place.has_localising()) record.localising = FromMessage(place.localising());
  return record;
}

void AddPart(const v1::WatchMapResponse& part, MapStep* step) {
  step->mark = {part.run(), part.revision()};
  step->restart = step->restart || part.restart();
  if (part.tile_m() > 0) step->tile_m = part.tile_m();
  for (const v1::TileInfo& tile : part.tiles()) step->tiles.push_back(FromMessage(tile));
  for (const v1::TileId& tile : part.removed_tiles()) {
    step->removed_tiles.push_back(FromMessage(tile));
  }
  for (const v1::SubmapPlace& place : part.submaps()) step->submaps.push_back(FromMessage(place));
  for (const v1::Match& match : part.matches()) step->matches.push_back(FromMessage(match));
  for (const v1::SessionPair& pair : part.removed_matches()) {
    step->removed_matches.emplace_back(pair.session_a(), pair.session_b());
  }
  if (!part.has_robots()) return;
  if (!step->robots) step->robots.emplace();
  for (const v1::RobotPlace& place : part.robots()) step->robots->push_back(FromMessage(place));
}

}  // namespace isthmus::convert
