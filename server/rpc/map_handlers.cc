#include "server/rpc/map_handlers.h"

#include <algorithm>
#include <optional>
#include <set>

#include "server/rpc/convert.h"
#include "server/rpc/robots_of.h"

namespace isthmus::rpc {
namespace {

using rpc::ToProto;  // Else hidden by the overloads below.

constexpr size_t kTrajectoryChunk = 1000;  // Poses in a response.

v1::Component ToProto(const server::ComponentInfo& info, const RobotOfSession& robot_of) {
  v1::Component proto;
  proto.set_component(info.component);
  proto.set_reference_session(info.reference.value());
  std::set<std::string> robots;
  for (const SessionId& session : info.sessions) {
    proto.add_sessions(session.value());
    robots.insert(RobotOf(robot_of, session));
  }
  robots.erase("");
  for (const std::string& robot : robots) proto.add_robots(robot);
  proto.set_point_count(info.point_count);
  if (!info.bounds.empty()) *proto.mutable_bounds() = ToProto(info.bounds);
  return proto;
}

v1::Submap ToProto(const server::SubmapStatus& status) {
  const SubmapInfo& info = status.info;
  v1::Submap proto;
  proto.set_session(info.id.session.value());
  proto.set_index(info.id.index);
  proto.set_robot(info.robot.value());
  *proto.mutable_t_odom_submap() = ToProto(info.T_odom_submap);
  proto.set_first_sequence(info.first_sequence);
  proto.set_last_sequence(info.last_sequence);
  proto.set_first_stamp_ns(info.first_stamp_ns);
  proto.set_last_stamp_ns(info.last_stamp_ns);
  proto.set_keyframe_count(info.keyframe_count);
  proto.set_point_count(info.point_count);
  if (!info.bounds.empty()) *proto.mutable_bounds() = ToProto(info.bounds);
  if (status.component) {
    proto.set_component(*status.component);
    *proto.mutable_t_map_submap() = ToProto(status.T_map_submap);
  }
  return proto;
}

std::optional<server::TrajectoryFrame> FromProto(v1::Frame frame) {
  if (frame == v1::ODOM) return server::TrajectoryFrame::kOdom;
  if (frame == v1::MAP) return server::TrajectoryFrame::kMap;
  return std::nullopt;
}

}  // namespace

absl::StatusOr<v1::MapInfo> GetMapInfo(server::Pipeline& pipeline, const v1::GetMapInfoRequest&) {
  const server::MapInfo info = pipeline.GetMapInfo();
  const RobotOfSession robots = RobotsOf(pipeline);
  v1::MapInfo proto;
  proto.set_revision(info.revision);
  for (const RobotId& robot : info.robots) proto.add_robots(robot.value());
  for (const server::ComponentInfo& component : info.components) {
    *proto.add_components() = ToProto(component, robots);
  }
  proto.set_settled(info.settled);
  proto.set_composition_ms(info.composition_ms);
  proto.set_composition_max_ms(info.composition_max_ms);
  proto.set_estimation_ms(info.estimation_ms);
  proto.set_compositions(info.compositions);
  proto.set_estimations(info.estimations);
  proto.set_placement_ms(info.placement_ms);
  proto.set_placements(info.placements);
  proto.set_submaps(info.submaps);
  proto.set_retired(info.retired);
  for (const std::string& problem : info.damaged) proto.add_damaged(problem);
  proto.set_storage_problem(info.storage_problem);
  return proto;
}

absl::StatusOr<v1::ListSubmapsResponse> ListSubmaps(server::Pipeline& pipeline,
                                                    const v1::ListSubmapsRequest& request) {
  std::optional<RobotId> robot;
  if (!request.robot().empty()) robot = RobotId(request.robot());
  v1::ListSubmapsResponse response;
  response.set_revision(pipeline.GetMapInfo().revision);
  const auto submaps = pipeline.ListSubmaps(robot);
  if (!submaps.ok()) return submaps.status();
  for (const server::SubmapStatus& submap : *submaps) *response.add_submaps() = ToProto(submap);
  return response;
}

absl::Status GetTrajectory(server::Pipeline& pipeline, const v1::GetTrajectoryRequest& request,
                           const Emit<v1::GetTrajectoryResponse>& emit) {
  const auto frame = FromProto(request.frame());
  if (!frame) {
    return absl::InvalidArgumentError("name the frame of the trajectory: ODOM or MAP");
  }
  const auto trajectory =
      pipeline.GetTrajectory(RobotId(request.robot()), *frame, request.segment());
  if (!trajectory.ok()) return trajectory.status();
  v1::GetTrajectoryResponse head;
  head.set_revision(trajectory->revision);
  head.set_session(trajectory->session.value());
  head.set_component(trajectory->component);
  for (const uint32_t segment : trajectory->left_out) head.add_segments_left_out(segment);
  size_t sent = 0;
  for (const server::RobotTrajectory::Part& part : trajectory->parts) {
    const size_t part_end = sent + part.count;
    do {  // At least one response, so that the segment is named also where there are no poses.
      v1::GetTrajectoryResponse response = head;
      response.set_segment(part.segment);
      const size_t end = std::min(sent + kTrajectoryChunk, part_end);
      for (; sent < end; ++sent) *response.add_poses() = ToProto(trajectory->poses[sent]);
      if (!emit(response)) return ReaderGone();
    } while (sent < part_end);
  }
  return absl::OkStatus();
}

absl::StatusOr<v1::GetTransformResponse> GetTransform(server::Pipeline& pipeline,
                                                      const v1::GetTransformRequest& request) {
  const auto transform =
      pipeline.GetTransform(RobotId(request.robot_a()), RobotId(request.robot_b()));
  if (!transform.ok()) return transform.status();
  v1::GetTransformResponse response;
  response.set_revision(transform->revision);
  *response.mutable_t_a_b() = ToProto(transform->T_a_b);
  return response;
}

}  // namespace isthmus::rpc
