#include "server/rpc/anchor_handlers.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/note.h"
#include "server/rpc/convert.h"
#include "server/rpc/robots_of.h"

namespace isthmus::rpc {
namespace {

using rpc::ToProto;  // Else hidden by the overload below.

v1::Anchor ToProto(const Anchor& anchor, const RobotOfSession& robots) {
  v1::Anchor proto;
  proto.set_session(anchor.submap.session.value());
  proto.set_index(anchor.submap.index);
  proto.set_robot(RobotOf(robots, anchor.submap.session));
  *proto.mutable_t_map_submap() = ToProto(anchor.T_map_submap);
  proto.set_sigma_xy_m(anchor.sigma_xy_m);
  proto.set_sigma_z_m(anchor.sigma_z_m);
  proto.set_sigma_deg(anchor.sigma_deg);
  proto.set_note(anchor.note);
  proto.set_given_ns(anchor.given_ns);
  return proto;
}

// The newest submap of the robot's newest session.
absl::StatusOr<SubmapId> NewestSubmap(server::Pipeline& pipeline, const RobotId& robot) {
  const auto submaps = pipeline.ListSubmaps(robot);
  if (!submaps.ok()) return submaps.status();
  std::optional<SessionId> session;
  for (const server::SessionStatus& status : pipeline.ListSessions()) {
    if (status.record.robot == robot) session = status.record.id;  // In order of creation.
  }
  std::optional<SubmapId> newest;
  for (const server::SubmapStatus& submap : *submaps) {
    if (submap.info.id.session != session) continue;
    newest = std::max(newest, std::optional(submap.info.id));
  }
  if (newest) return *newest;
  return absl::FailedPreconditionError(
      absl::StrCat("the newest session of ", robot.value(),
                   " has no submap yet: try again when it has driven on, or name a submap"));
}

absl::StatusOr<SubmapId> AnchoredSubmap(server::Pipeline& pipeline,
                                        const v1::PutAnchorRequest& request) {
  const v1::Anchor& anchor = request.anchor();
  if (!anchor.session().empty()) return SubmapId{SessionId(anchor.session()), anchor.index()};
  if (!request.robot().empty()) return NewestSubmap(pipeline, RobotId(request.robot()));
  return absl::InvalidArgumentError("name a submap by session and index, or a robot");
}

absl::Status CheckSigma(double sigma, const char* name) {
  if (std::isfinite(sigma) && sigma >= 0) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(name, " is ", sigma, ": give a standard deviation, or 0 for what is not known"));
}

// All but the submap.
absl::StatusOr<Anchor> FromProto(const v1::Anchor& proto) {
  if (!proto.has_t_map_submap()) {
    return absl::InvalidArgumentError("an anchor needs t_map_submap, the place of the submap");
  }
  const auto pose = rpc::FromProto(proto.t_map_submap(), "t_map_submap");
  absl::Status status = pose.status();
  if (status.ok()) status = CheckSigma(proto.sigma_xy_m(), "sigma_xy_m");
  if (status.ok()) status = CheckSigma(proto.sigma_z_m(), "sigma_z_m");
  if (status.ok()) status = CheckSigma(proto.sigma_deg(), "sigma_deg");
  if (status.ok()) status = CheckNote(proto.note());
  if (!status.ok()) return status;
  Anchor anchor;
  anchor.T_map_submap = *pose;
  anchor.sigma_xy_m = proto.sigma_xy_m();
  anchor.sigma_z_m = proto.sigma_z_m();
  anchor.sigma_deg = proto.sigma_deg();
  anchor.note = proto.note();
  return anchor;
}

}  // namespace

absl::StatusOr<v1::PutAnchorResponse> PutAnchor(server::Pipeline& pipeline,
                                                const v1::PutAnchorRequest& request) {
  auto anchor = FromProto(request.anchor());
  if (!anchor.ok()) return anchor.status();
  const auto submap = AnchoredSubmap(pipeline, request);
  if (!submap.ok()) return submap.status();
  anchor->submap = *submap;
  const auto revision = pipeline.PutAnchor(*std::move(anchor));
  if (!revision.ok()) return revision.status();
  v1::PutAnchorResponse response;
  response.set_revision(*revision);
  response.set_session(submap->session.value());
  response.set_index(submap->index);
  return response;
}

absl::StatusOr<v1::DeleteAnchorResponse> DeleteAnchor(server::Pipeline& pipeline,
                                                      const v1::DeleteAnchorRequest& request) {
  const auto revision = pipeline.RemoveAnchor({SessionId(request.session()), request.index()});
  if (!revision.ok()) return revision.status();
  v1::DeleteAnchorResponse response;
  response.set_revision(*revision);
  return response;
}

absl::StatusOr<v1::ListAnchorsResponse> ListAnchors(server::Pipeline& pipeline,
                                                    const v1::ListAnchorsRequest&) {
  v1::ListAnchorsResponse response;
  response.set_revision(pipeline.GetMapInfo().revision);
  const RobotOfSession robots = RobotsOf(pipeline);
  for (const Anchor& anchor : pipeline.ListAnchors()) {
    *response.add_anchors() = ToProto(anchor, robots);
  }
  return response;
}

}  // namespace isthmus::rpc
