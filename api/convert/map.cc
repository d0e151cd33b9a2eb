#include "api/convert/map.h"

#include <absl/strings/str_cat.h>

#include <optional>
#include <string>
#include <utility>

#include "api/convert/geometry.h"

namespace isthmus::convert {
namespace {

v1::Component ComponentMessage(const Component& component) {
  v1::Component message;
  message.set_component(component.component);
  message.set_reference_session(component.reference.value());
  for (const SessionId& session : component.sessions) message.add_sessions(session.value());
  for (const RobotId& robot : component.robots) message.add_robots(robot.value());
  message.set_point_count(component.point_count);
  if (!component.bounds.empty()) *message.mutable_bounds() = ToMessage(component.bounds);
  return message;
}

Component ComponentOf(const v1::Component& component) {
  Component record;
  record.component = component.component();
  record.reference = SessionId(component.reference_session());
  for (const std::string& session : component.sessions()) record.sessions.emplace_back(session);
  for (const std::string& robot : component.robots()) record.robots.emplace_back(robot);
  record.point_count = component.point_count();
  if (component.has_bounds()) record.bounds = FromMessage(component.bounds());
  return record;
}

}  // namespace

v1::MapInfo ToMessage(const MapInfo& info) {
  v1::MapInfo message;
  message.set_revision(info.revision);
  for (const RobotId& robot : info.robots) message.add_robots(robot.value());
  for (const Component& component : info.components) {
    *message.add_components() = ComponentMessage(component);
  }
  message.set_settled(info.settled);
  message.set_composition_ms(info.composition_ms);
  message.set_composition_max_ms(info.composition_max_ms);
  message.set_estimation_ms(info.estimation_ms);
  message.set_placement_ms(info.placement_ms);
  message.set_compositions(info.compositions);
  message.set_estimations(info.estimations);
  message.set_placements(info.placements);
  message.set_submaps(info.submaps);
  message.set_retired(info.retired);
  for (const std::string& problem : info.damaged) message.add_damaged(problem);
  message.set_storage_problem(info.storage_problem);
  if (info.datum) *message.mutable_datum() = ToMessage(*info.datum);
  if (info.replica) *message.mutable_replica() = ToMessage(*info.replica);
  return message;
}

MapInfo FromMessage(const v1::MapInfo& info) {
  MapInfo record;
  record.revision = info.revision();
  for (const std::string& robot : info.robots()) record.robots.emplace_back(robot);
  for (const v1::Component& component : info.components()) {
    record.components.push_back(ComponentOf(component));
  }
  record.settled = info.settled();
  record.composition_ms = info.composition_ms();
  record.composition_max_ms = info.composition_max_ms();
  record.estimation_ms = info.estimation_ms();
  record.placement_ms = info.placement_ms();
  record.compositions = info.compositions();
  record.estimations = info.estimations();
  record.placements = info.placements();
  record.submaps = info.submaps();
  record.retired = info.retired();
  record.damaged.assign(info.damaged().begin(), info.damaged().end());
  record.storage_problem = info.storage_problem();
  if (info.has_datum()) record.datum = FromMessage(info.datum());
  if (info.has_replica()) record.replica = FromMessage(info.replica());
  return record;
}

v1::ReplicaState ToMessage(const ReplicaState& state) {
  v1::ReplicaState message;
  message.set_owner(state.owner);
  message.set_behind_s(state.behind_s);
  message.set_problem(state.problem);
  return message;
}

ReplicaState FromMessage(const v1::ReplicaState& state) {
  return {.owner = state.owner(), .behind_s = state.behind_s(), .problem = state.problem()};
}

v1::Datum ToMessage(const Datum& datum) {
  v1::Datum message;
  message.set_latitude_deg(datum.latitude_deg);
  message.set_longitude_deg(datum.longitude_deg);
  message.set_altitude_m(datum.altitude_m);
  message.set_heading_deg(datum.heading_deg);
  message.set_given_ns(datum.given_ns);
  return message;
}

Datum FromMessage(const v1::Datum& datum) {
  return {.latitude_deg = datum.latitude_deg(),
          .longitude_deg = datum.longitude_deg(),
          .altitude_m = datum.altitude_m(),
          .heading_deg = datum.heading_deg(),
          .given_ns = datum.given_ns()};
}

v1::Submap ToMessage(const SubmapStatus& status) {
  const SubmapInfo& info = status.info;
  v1::Submap message;
  message.set_session(info.id.session.value());
  message.set_index(info.id.index);
  message.set_robot(info.robot.value());
  *message.mutable_t_odom_submap() = ToMessage(info.T_odom_submap);
  message.set_first_sequence(info.first_sequence);
  message.set_last_sequence(info.last_sequence);
  message.set_first_stamp_ns(info.first_stamp_ns);
  message.set_last_stamp_ns(info.last_stamp_ns);
  message.set_keyframe_count(info.keyframe_count);
  message.set_point_count(info.point_count);
  if (!info.bounds.empty()) *message.mutable_bounds() = ToMessage(info.bounds);
  if (status.component) {
    message.set_component(*status.component);
    *message.mutable_t_map_submap() = ToMessage(status.T_map_submap);
  }
  return message;
}

SubmapStatus FromMessage(const v1::Submap& submap) {
  SubmapStatus status;
  SubmapInfo& info = status.info;
  info.id = {SessionId(submap.session()), submap.index()};
  info.robot = RobotId(submap.robot());
  info.T_odom_submap = FromMessage(submap.t_odom_submap());
  info.first_sequence = submap.first_sequence();
  info.last_sequence = submap.last_sequence();
  info.first_stamp_ns = submap.first_stamp_ns();
  info.last_stamp_ns = submap.last_stamp_ns();
  info.keyframe_count = submap.keyframe_count();
  info.point_count = submap.point_count();
  if (submap.has_bounds()) info.bounds = FromMessage(submap.bounds());
  if (submap.has_component()) status.component = submap.component();
  status.T_map_submap = FromMessage(submap.t_map_submap());
  return status;
}

v1::Frame ToMessage(TrajectoryFrame frame) {
  return frame == TrajectoryFrame::kMap ? v1::MAP : v1::ODOM;
}

absl::StatusOr<TrajectoryFrame> FromMessage(v1::Frame frame) {
  if (frame == v1::ODOM) return TrajectoryFrame::kOdom;
  if (frame == v1::MAP) return TrajectoryFrame::kMap;
  return absl::InvalidArgumentError("name the frame of the trajectory: ODOM or MAP");
}

}  // namespace isthmus::convert
