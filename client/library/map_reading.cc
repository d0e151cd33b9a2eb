// The part of Client that reads the map, and says how it hangs together.
#include <string>

#include "client/library/client.h"
#include "client/library/convert.h"
#include "client/library/link.h"

namespace isthmus::client {

using Stubs = Client::Link::Stubs;

absl::StatusOr<MapInfo> Client::GetMapInfo() {
  v1::MapInfo info;
  const absl::Status status =
      link_->Call(link_->options().call_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.maps->GetMapInfo(&context, v1::GetMapInfoRequest(), &info);
      });
  if (!status.ok()) return status;
  return FromProto(info);
}

absl::StatusOr<std::vector<SubmapStatus>> Client::ListSubmaps(const RobotId& robot) {
  v1::ListSubmapsRequest request;
  request.set_robot(robot.value());
  v1::ListSubmapsResponse response;
  const absl::Status status =
      link_->Call(link_->options().call_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.maps->ListSubmaps(&context, request, &response);
      });
  if (!status.ok()) return status;
  std::vector<SubmapStatus> submaps;
  for (const v1::Submap& submap : response.submaps()) submaps.push_back(FromProto(submap));
  return submaps;
}

absl::StatusOr<RobotTrajectory> Client::GetTrajectory(const RobotId& robot, Frame frame,
                                                      uint32_t segment) {
  v1::GetTrajectoryRequest request;
  request.set_robot(robot.value());
  request.set_frame(frame == Frame::kMap ? v1::MAP : v1::ODOM);
  request.set_segment(segment);
  RobotTrajectory trajectory;
  const auto read = [&](Stubs& stubs, grpc::ClientContext& context) {
    trajectory = {};
    auto reader = stubs.maps->GetTrajectory(&context, request);
    v1::GetTrajectoryResponse part;
    while (reader->Read(&part)) {
      trajectory.session = SessionId(part.session());
      trajectory.revision = part.revision();
      trajectory.component = part.component();
      trajectory.left_out.assign(part.segments_left_out().begin(), part.segments_left_out().end());
      if (trajectory.parts.empty() || trajectory.parts.back().segment != part.segment()) {
        trajectory.parts.push_back({part.segment(), 0});
      }
      trajectory.parts.back().count += static_cast<size_t>(part.poses_size());
      for (const v1::StampedPose& pose : part.poses()) {
        trajectory.poses.push_back({pose.stamp_ns(), FromProto(pose.pose())});
      }
    }
    return reader->Finish();
  };
  const absl::Status status = link_->Call(link_->options().transfer_timeout_s, read);
  if (!status.ok()) return status;
  return trajectory;
}

absl::StatusOr<MatchGraph> Client::GetMatchGraph(bool include_edges) {
  v1::GetMatchGraphRequest request;
  request.set_include_edges(include_edges);
  v1::MatchGraph graph;
  const absl::Status status =
      link_->Call(link_->options().call_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.maps->GetMatchGraph(&context, request, &graph);
      });
  if (!status.ok()) return status;
  return FromProto(graph);
}

absl::StatusOr<MatchEdge> Client::DecideMatch(const MatchDecision& decision) {
  const v1::DecideMatchRequest request = ToProto(decision);
  v1::DecideMatchResponse response;
  // May be repeated: the same decision twice is one.
  const absl::Status status = link_->Call(
      link_->options().transfer_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.matches->DecideMatch(&context, request, &response);
      });
  if (!status.ok()) return status;
  return FromProto(response.match());
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
  return RobotTransform{response.revision(), FromProto(response.t_a_b())};
}

absl::Status Client::QueryRegion(const RegionQuery& query,
                                 const std::function<bool(const RegionChunk&)>& chunk) {
  const v1::QueryRegionRequest request = ToProto(query);
  bool started = false;
  absl::Status failure;  // Found on this side.
  const auto read = [&](Stubs& stubs, grpc::ClientContext& context) {
    auto reader = stubs.maps->QueryRegion(&context, request);
    v1::QueryRegionResponse part;
    RegionChunk out;
    while (failure.ok() && reader->Read(&part)) {
      started = true;
      out.revision = part.revision();
      for (const std::string& robot : part.robots()) out.robots.emplace_back(robot);
      out.points.clear();
      failure = AppendPoints(part.cloud(), out.points);
      if (failure.ok() && !chunk(out)) failure = absl::CancelledError("stopped by the reader");
      if (!failure.ok()) context.TryCancel();
    }
    return reader->Finish();
  };
  const absl::Status status = link_->Repeat(false, [&] {
    const absl::Status once = link_->Once(link_->options().transfer_timeout_s, read);
    return started ? NotAgain(once) : once;
  });
  return failure.ok() ? status : failure;
}

}  // namespace isthmus::client
