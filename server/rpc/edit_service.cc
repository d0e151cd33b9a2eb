// Changes of the map by hand. What each method returns and fails with is said in
// api/isthmus/v1/edit_service.proto.
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <optional>

#include "api/convert/graph.h"
#include "api/convert/map.h"
#include "isthmus/v1/edit_service.grpc.pb.h"
#include "server/rpc/services.h"

namespace isthmus::rpc {
namespace {

absl::StatusOr<SubmapId> NewestSubmap(const Call& call, const RobotId& robot) {
  const auto submaps = call.pipeline().reader().ListSubmaps(robot);
  if (!submaps.ok()) return submaps.status();
  std::optional<SessionId> session;
  for (const SessionStatus& status : call.pipeline().sessions().List()) {
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

// The submap that the request means; for a robot, its newest session's.
absl::StatusOr<SubmapId> AnchoredSubmap(const Call& call, const v1::PutAnchorRequest& request) {
  const v1::Anchor& anchor = request.anchor();
  if (!anchor.session().empty()) return SubmapId{SessionId(anchor.session()), anchor.index()};
  if (!request.robot().empty()) return NewestSubmap(call, RobotId(request.robot()));
  return absl::InvalidArgumentError("name a submap by session and index, or a robot");
}

class EditService final : public v1::EditService::Service {
 public:
  explicit EditService(const ServiceParts& parts) : gate_(parts.gate) {}

  grpc::Status DecideMatch(grpc::ServerContext* context, const v1::DecideMatchRequest* request,
                           v1::DecideMatchResponse* response) override {
    return gate_.Serve(context, *request, "DecideMatch", [&](const Call& call) -> absl::Status {
      const auto decision = convert::FromMessage(*request);
      if (!decision.ok()) return decision.status();
      const auto decided = call.pipeline().decisions().DecideMatch(*decision, call.actor());
      if (decided.ok()) {
        response->set_revision(decided->revision);
        *response->mutable_match() = convert::ToMessage(decided->edge);
      }
      return decided.status();
    });
  }

  grpc::Status DecideLoop(grpc::ServerContext* context, const v1::DecideLoopRequest* request,
                          v1::DecideLoopResponse* response) override {
    return gate_.Serve(context, *request, "DecideLoop", [&](const Call& call) -> absl::Status {
      const auto decision = convert::FromMessage(*request);
      if (!decision.ok()) return decision.status();
      const auto decided = call.pipeline().decisions().DecideLoop(*decision, call.actor());
      if (decided.ok()) {
        response->set_revision(decided->revision);
        *response->mutable_loop() = convert::ToMessage(decided->loop);
      }
      return decided.status();
    });
  }

  grpc::Status PutAnchor(grpc::ServerContext* context, const v1::PutAnchorRequest* request,
                         v1::PutAnchorResponse* response) override {
    return gate_.Serve(context, *request, "PutAnchor", [&](const Call& call) -> absl::Status {
      auto anchor = convert::Checked(request->anchor());
      if (!anchor.ok()) return anchor.status();
      const auto submap = AnchoredSubmap(call, *request);
      if (!submap.ok()) return submap.status();
      anchor->submap = *submap;
      const auto revision = call.pipeline().decisions().PutAnchor(*std::move(anchor), call.actor());
      if (revision.ok()) {
        response->set_revision(*revision);
        response->set_session(submap->session.value());
        response->set_index(submap->index);
      }
      return revision.status();
    });
  }

  grpc::Status DeleteAnchor(grpc::ServerContext* context, const v1::DeleteAnchorRequest* request,
                            v1::DeleteAnchorResponse* response) override {
    return gate_.Serve(context, *request, "DeleteAnchor", [&](const Call& call) -> absl::Status {
      const auto revision = call.pipeline().decisions().RemoveAnchor(
          {SessionId(request->session()), request->index()}, call.actor());
      if (revision.ok()) response->set_revision(*revision);
      return revision.status();
    });
  }

  grpc::Status SetDatum(grpc::ServerContext* context, const v1::SetDatumRequest* request,
                        v1::SetDatumResponse* response) override {
    return gate_.Serve(context, *request, "SetDatum", [&](const Call& call) -> absl::Status {
      std::optional<Datum> datum;
      if (request->has_datum()) datum = convert::FromMessage(request->datum());
      const absl::Status status = call.pipeline().decisions().SetDatum(datum, call.actor());
      if (status.ok()) response->set_revision(call.pipeline().GetMapInfo().revision);
      return status;
    });
  }

  grpc::Status UndoRevision(grpc::ServerContext* context, const v1::UndoRevisionRequest* request,
                            v1::UndoRevisionResponse* response) override {
    return gate_.Serve(context, *request, "UndoRevision", [&](const Call& call) -> absl::Status {
      const auto revision = call.pipeline().decisions().UndoRevision(request->revision(),
                                                                     request->note(), call.actor());
      if (revision.ok()) response->set_revision(*revision);
      return revision.status();
    });
  }

  grpc::Status DeleteSession(grpc::ServerContext* context, const v1::DeleteSessionRequest* request,
                             v1::DeleteSessionResponse*) override {
    return gate_.Serve(context, *request, "DeleteSession", [&](const Call& call) -> absl::Status {
      const SessionId session(request->session());
      const absl::Status status = call.pipeline().sessions().Delete(session, call.actor());
      // Its queued scans are gone without acknowledgement: a stream would wait for them forever.
      if (status.ok()) {
        call.site->streams.Drop(session);
        call.site->staging.DropSession(session);
      }
      return status;
    });
  }

 private:
  Gate& gate_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeEditService(const ServiceParts& parts) {
  return std::make_unique<EditService>(parts);
}

}  // namespace isthmus::rpc
