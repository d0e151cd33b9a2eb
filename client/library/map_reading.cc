// The part of Client that reads the map: what is in it, and where it lies.
#include <string>

#include "api/convert/geometry.h"
#include "api/convert/map.h"
#include "api/convert/status.h"
#include "client/library/client.h"
#include "client/library/list_stream.h"

namespace isthmus::client {

using Stubs = Client::Link::Stubs;

absl::StatusOr<ServerStatus> Client::GetStatus() {
  v1::ServerStatus message;
  const absl::Status status =
      link_->Call(link_->options().call_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.admin->GetStatus(&context, v1::GetStatusRequest(), &message);
      });
  if (!status.ok()) return status;
  return convert::FromMessage(message);
}

absl::StatusOr<MapInfo> Client::GetMapInfo() {
  v1::MapInfo info;
  const absl::Status status =
      link_->Call(link_->options().call_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.maps->GetMapInfo(&context, v1::GetMapInfoRequest(), &info);
      });
  if (!status.ok()) return status;
  return convert::FromMessage(info);
}

namespace {

void AddSubmaps(const v1::ListSubmapsResponse& part, ListAt<SubmapStatus>& submaps) {
  submaps.revision = part.revision();
  for (const v1::Submap& submap : part.submaps()) submaps.push_back(convert::FromMessage(submap));
}

void AddPoses(const v1::GetTrajectoryResponse& part, RobotTrajectory& trajectory) {
  trajectory.session = SessionId(part.session());
  trajectory.revision = part.revision();
  trajectory.component = part.component();
  trajectory.left_out.assign(part.segments_left_out().begin(), part.segments_left_out().end());
  if (trajectory.parts.empty() || trajectory.parts.back().segment != part.segment()) {
    trajectory.parts.push_back({part.segment(), 0});
  }
  trajectory.parts.back().count += static_cast<size_t>(part.poses_size());
  for (const v1::StampedPose& pose : part.poses()) {
    trajectory.poses.push_back(convert::FromMessage(pose));
  }
}

}  // namespace

absl::StatusOr<ListAt<SubmapStatus>> Client::ListSubmaps(const RobotId& robot) {
  v1::ListSubmapsRequest request;
  request.set_robot(robot.value());
  const auto open = [&](Stubs& stubs, grpc::ClientContext& context) {
    return stubs.maps->ListSubmaps(&context, request);
  };
  return ReadList(*link_, open, AddSubmaps);
}

absl::StatusOr<RobotTrajectory> Client::GetTrajectory(const RobotId& robot, TrajectoryFrame frame,
                                                      uint32_t segment) {
  v1::GetTrajectoryRequest request;
  request.set_robot(robot.value());
  request.set_frame(convert::ToMessage(frame));
  request.set_segment(segment);
  const auto open = [&](Stubs& stubs, grpc::ClientContext& context) {
    return stubs.maps->GetTrajectory(&context, request);
  };
  return ReadList(*link_, open, AddPoses);
}

absl::StatusOr<RobotTransform> Client::GetTransform(const RobotId& a, const RobotId& b) {
  v1::GetTransformRequest request;
  request.set_robot_a(a.value());
  request.set_robot_b(b.value());
  v1::GetTransformResponse response;
  const absl::Status status =
      link_->Call(link_->options().call_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.maps->GetTransform(&context, request, &response);
      });
  if (!status.ok()) return status;
  return RobotTransform{response.revision(), convert::FromMessage(response.t_a_b())};
}

}  // namespace isthmus::client
