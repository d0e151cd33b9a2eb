#include "server/rpc/session_handlers.h"

#include <absl/strings/str_cat.h>

#include "server/rpc/convert.h"

namespace isthmus::rpc {
namespace {

using rpc::ToProto;  // Else hidden by the overloads below.

v1::Session ToProto(const server::SessionStatus& status) {
  v1::Session proto;
  const SessionRecord& record = status.record;
  proto.set_id(record.id.value());
  proto.set_robot(record.robot.value());
  proto.set_sensor(record.sensor);
  *proto.mutable_t_base_sensor() = ToProto(record.T_base_sensor);
  proto.set_state(record.state == SessionState::kActive ? v1::Session::ACTIVE
                                                        : v1::Session::FINISHED);
  proto.set_created_ns(record.created_ns);
  proto.set_finished_ns(record.finished_ns);
  proto.set_last_sequence(status.last_sequence);
  proto.set_durable_sequence(status.durable_sequence);
  proto.set_scans_processed(status.scans_processed);
  proto.set_scans_rejected(status.scans_rejected);
  proto.set_submap_count(status.submap_count);
  proto.set_point_count(status.point_count);
  proto.set_odometry_ms_mean(status.odometry_ms_mean);
  proto.set_travelled_m(status.travelled_m);
  proto.set_tracking(status.tracking);
  proto.set_odometry(record.odometry);
  proto.set_input(status.input);
  proto.set_map_bytes(status.map_bytes);
  proto.set_scan_bytes(status.scan_bytes);
  proto.set_quota_bytes(status.quota_bytes);
  proto.set_archive_problem(status.archive_problem);
  proto.set_segment(record.segment);
  proto.set_first_segment(record.first_segment.value());
  if (record.segment == 1) {
    proto.set_segments(status.segments);
    *proto.mutable_scan_counts() = ToProto(status.scans);
    proto.set_lost_since_ns(status.lost_since_ns);
  }
  if (status.placement) {
    proto.set_component(status.placement->component);
    *proto.mutable_t_map_odom() = ToProto(status.placement->T_map_odom);
  }
  return proto;
}

absl::StatusOr<v1::Session> ToProto(const absl::StatusOr<server::SessionStatus>& status) {
  if (!status.ok()) return status.status();
  return ToProto(*status);
}

}  // namespace

absl::StatusOr<v1::Session> CreateSession(server::Pipeline& pipeline,
                                          const v1::CreateSessionRequest& request) {
  server::SessionRequest wanted{RobotId(request.robot()), request.sensor(), request.odometry()};
  wanted.request_id = request.request_id();
  if (request.has_t_base_sensor()) {
    const auto pose = FromProto(request.t_base_sensor(), "t_base_sensor");
    if (!pose.ok()) return pose.status();
    wanted.T_base_sensor = *pose;
  }
  return ToProto(pipeline.CreateSession(wanted));
}

absl::StatusOr<v1::Session> GetSession(server::Pipeline& pipeline,
                                       const v1::GetSessionRequest& request) {
  return ToProto(pipeline.GetSession(SessionId(request.session())));
}

absl::StatusOr<v1::ListSessionsResponse> ListSessions(server::Pipeline& pipeline,
                                                      const v1::ListSessionsRequest&) {
  v1::ListSessionsResponse response;
  for (const server::SessionStatus& status : pipeline.ListSessions()) {
    *response.add_sessions() = ToProto(status);
  }
  return response;
}

absl::StatusOr<v1::Session> FinishSession(server::Pipeline& pipeline,
                                          const v1::FinishSessionRequest& request) {
  const SessionId session(request.session());
  if (request.last_sequence() > 0) {
    // It only falls behind this if the process is started anew, and this call ends with it.
    const auto status = pipeline.GetSession(session);
    if (!status.ok()) return status.status();
    if (status->last_sequence < request.last_sequence()) {
      return absl::AbortedError(absl::StrCat("session ", session.value(), " has scans up to ",
                                             status->last_sequence, " of ", request.last_sequence(),
                                             ": send the rest again, then finish it"));
    }
  }
  return ToProto(pipeline.FinishSession(session));
}

absl::StatusOr<v1::DeleteSessionResponse> DeleteSession(server::Pipeline& pipeline,
                                                        const v1::DeleteSessionRequest& request) {
  const absl::Status status = pipeline.DeleteSession(SessionId(request.session()));
  if (!status.ok()) return status;
  return v1::DeleteSessionResponse();
}

}  // namespace isthmus::rpc
