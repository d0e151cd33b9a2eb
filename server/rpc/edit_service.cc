#include "server/rpc/edit_service.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <optional>

#include "api/convert/graph.h"
#include "api/convert/map.h"

namespace isthmus::rpc {

grpc::Status EditService::DecideMatch(grpc::ServerContext*, const v1::DecideMatchRequest* request,
                                      v1::DecideMatchResponse* response) {
  return reply_("DecideMatch", [&]() -> absl::Status {
    const auto decision = convert::FromMessage(*request);
    if (!decision.ok()) return decision.status();
    const auto decided = pipeline_.DecideMatch(*decision);
    if (decided.ok()) {
      response->set_revision(decided->revision);
      *response->mutable_match() = convert::ToMessage(decided->edge);
    }
    return decided.status();
  });
}

grpc::Status EditService::DecideLoop(grpc::ServerContext*, const v1::DecideLoopRequest* request,
                                     v1::DecideLoopResponse* response) {
  return reply_("DecideLoop", [&]() -> absl::Status {
    const auto decision = convert::FromMessage(*request);
    if (!decision.ok()) return decision.status();
    const auto decided = pipeline_.DecideLoop(*decision);
    if (decided.ok()) {
      response->set_revision(decided->revision);
      *response->mutable_loop() = convert::ToMessage(decided->loop);
    }
    return decided.status();
  });
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
  return reply_("PutAnchor", [&]() -> absl::Status {
    auto anchor = convert::Checked(request->anchor());
    if (!anchor.ok()) return anchor.status();
    const auto submap = AnchoredSubmap(*request);
    if (!submap.ok()) return submap.status();
    anchor->submap = *submap;
    const auto revision = pipeline_.PutAnchor(*std::move(anchor));
    if (revision.ok()) {
      response->set_revision(*revision);
      response->set_session(submap->session.value());
      response->set_index(submap->index);
    }
    return revision.status();
  });
}

grpc::Status EditService::DeleteAnchor(grpc::ServerContext*, const v1::DeleteAnchorRequest* request,
                                       v1::DeleteAnchorResponse* response) {
  return reply_("DeleteAnchor", [&]() -> absl::Status {
    const auto revision = pipeline_.RemoveAnchor({SessionId(request->session()), request->index()});
    if (revision.ok()) response->set_revision(*revision);
    return revision.status();
  });
}

grpc::Status EditService::SetDatum(grpc::ServerContext*, const v1::SetDatumRequest* request,
                                   v1::SetDatumResponse* response) {
  return reply_("SetDatum", [&]() -> absl::Status {
    std::optional<Datum> datum;
    if (request->has_datum()) datum = convert::FromMessage(request->datum());
    const absl::Status status = pipeline_.SetDatum(datum);
    if (status.ok()) response->set_revision(pipeline_.GetMapInfo().revision);
    return status;
  });
}

grpc::Status EditService::UndoRevision(grpc::ServerContext*, const v1::UndoRevisionRequest* request,
                                       v1::UndoRevisionResponse* response) {
  return reply_("UndoRevision", [&]() -> absl::Status {
    const auto revision = pipeline_.UndoRevision(request->revision(), request->note());
    if (revision.ok()) response->set_revision(*revision);
    return revision.status();
  });
}

grpc::Status EditService::DeleteSession(grpc::ServerContext*,
                                        const v1::DeleteSessionRequest* request,
                                        v1::DeleteSessionResponse*) {
  return reply_("DeleteSession", [&]() -> absl::Status {
    const SessionId session(request->session());
    const absl::Status status = pipeline_.DeleteSession(session);
    // Its queued scans are gone without acknowledgement: a stream would wait for them forever.
    if (status.ok()) {
      streams_.Drop(session);
      staging_.DropSession(session);
    }
    return status;
  });
}

}  // namespace isthmus::rpc
