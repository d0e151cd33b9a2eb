#include "server/rpc/edit_service.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <optional>

#include "api/convert/graph.h"

namespace isthmus::rpc {

grpc::Status EditService::DecideMatch(grpc::ServerContext*, const v1::DecideMatchRequest* request,
                                      v1::DecideMatchResponse* response) {
  const auto decision = convert::FromMessage(*request);
  if (!decision.ok()) return reply_("DecideMatch", decision);
  const auto decided = pipeline_.DecideMatch(*decision);
  if (decided.ok()) {
    response->set_revision(decided->revision);
    *response->mutable_match() = convert::ToMessage(decided->edge);
  }
  return reply_("DecideMatch", decided);
}

grpc::Status EditService::DecideLoop(grpc::ServerContext*, const v1::DecideLoopRequest* request,
                                     v1::DecideLoopResponse* response) {
  const auto decision = convert::FromMessage(*request);
  if (!decision.ok()) return reply_("DecideLoop", decision);
  const auto decided = pipeline_.DecideLoop(*decision);
  if (decided.ok()) {
    response->set_revision(decided->revision);
    *response->mutable_loop() = convert::ToMessage(decided->loop);
  }
  return reply_("DecideLoop", decided);
}

absl::StatusOr<SubmapId> EditService::NewestSubmap(const RobotId& robot) {
  const auto submaps = pipeline_.ListSubmaps(robot);
  if (!submaps.ok()) return submaps.status();
  std::optional<SessionId> session;
  for (const SessionStatus& status : pipeline_.ListSessions()) {
    if (status.record.robot == robot) session = status.record.id;  // In order of creation.
  }
  std::optional<SubmapId> newest;
  for (const SubmapStatus& submap : *submaps) {
    if (submap.info.id.session != session) continue;
    newest = std::max(newest, std::optional(submap.info.id));
  }
  if (newest) return *newest;
  return absl::FailedPreconditionError(
      absl::StrCat("the newest session of ", robot.value(),
                   " has no submap yet: try again when it has driven on, or name a submap"));
}

absl::StatusOr<SubmapId> EditService::AnchoredSubmap(const v1::PutAnchorRequest& request) {
  const v1::Anchor& anchor = request.anchor();
  if (!anchor.session().empty()) return SubmapId{SessionId(anchor.session()), anchor.index()};
  if (!request.robot().empty()) return NewestSubmap(RobotId(request.robot()));
  return absl::InvalidArgumentError("name a submap by session and index, or a robot");
}

grpc::Status EditService::PutAnchor(grpc::ServerContext*, const v1::PutAnchorRequest* request,
                                    v1::PutAnchorResponse* response) {
  auto anchor = convert::Checked(request->anchor());
  if (!anchor.ok()) return reply_("PutAnchor", anchor);
  const auto submap = AnchoredSubmap(*request);
  if (!submap.ok()) return reply_("PutAnchor", submap);
  anchor->submap = *submap;
  const auto revision = pipeline_.PutAnchor(*std::move(anchor));
  if (revision.ok()) {
    response->set_revision(*revision);
    response->set_session(submap->session.value());
    response->set_index(submap->index);
  }
  return reply_("PutAnchor", revision);
}

grpc::Status EditService::DeleteAnchor(grpc::ServerContext*, const v1::DeleteAnchorRequest* request,
                                       v1::DeleteAnchorResponse* response) {
  const auto revision = pipeline_.RemoveAnchor({SessionId(request->session()), request->index()});
  if (revision.ok()) response->set_revision(*revision);
  return reply_("DeleteAnchor", revision);
}

grpc::Status EditService::UndoRevision(grpc::ServerContext*, const v1::UndoRevisionRequest* request,
                                       v1::UndoRevisionResponse* response) {
  const auto revision = pipeline_.UndoRevision(request->revision(), request->note());
  if (revision.ok()) response->set_revision(*revision);
  return reply_("UndoRevision", revision);
}

grpc::Status EditService::DeleteSession(grpc::ServerContext*,
                                        const v1::DeleteSessionRequest* request,
                                        v1::DeleteSessionResponse*) {
  const SessionId session(request->session());
  const absl::Status status = pipeline_.DeleteSession(session);
  // Its queued scans are gone without acknowledgement: a stream would wait for them for ever.
  if (status.ok()) {
    streams_.Drop(session);
    staging_.DropSession(session);
  }
  return reply_("DeleteSession", status);
}

}  // namespace isthmus::rpc
