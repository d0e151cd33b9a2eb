// The part of Client that says something of the map.
#include <string>

#include "api/convert/graph.h"
#include "api/convert/map.h"
#include "client/library/client.h"
#include "client/library/link.h"

namespace isthmus::client {

using Stubs = Client::Link::Stubs;

absl::StatusOr<DecidedMatch> Client::DecideMatch(const MatchDecision& decision) {
  const v1::DecideMatchRequest request = convert::ToMessage(decision);
  v1::DecideMatchResponse response;
  // May be repeated: the same decision twice is one.
  const absl::Status status = link_->Call(
      link_->options().transfer_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.edits->DecideMatch(&context, request, &response);
      });
  if (!status.ok()) return status;
  return DecidedMatch{response.revision(), convert::FromMessage(response.match())};
}

absl::StatusOr<DecidedLoop> Client::DecideLoop(const LoopDecision& decision) {
  const v1::DecideLoopRequest request = convert::ToMessage(decision);
  v1::DecideLoopResponse response;
  // May be repeated: the same decision twice is one.
  const absl::Status status = link_->Call(
      link_->options().transfer_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.edits->DecideLoop(&context, request, &response);
      });
  if (!status.ok()) return status;
  return DecidedLoop{response.revision(), convert::FromMessage(response.loop())};
}

absl::StatusOr<Anchored> Client::PutAnchor(const Anchor& anchor, const RobotId& robot) {
  v1::PutAnchorRequest request;
  *request.mutable_anchor() = convert::ToMessage(RobotAnchor{anchor});
  request.set_robot(robot.value());
  v1::PutAnchorResponse response;
  const auto put = [&](Stubs& stubs, grpc::ClientContext& context) {
    return stubs.edits->PutAnchor(&context, request, &response);
  };
  // The same anchor twice is one; but what a robot's newest submap is changes.
  const double timeout_s = link_->options().transfer_timeout_s;
  const absl::Status status =
      anchor.submap.session.empty() ? link_->CallOnce(timeout_s, put) : link_->Call(timeout_s, put);
  if (!status.ok()) return status;
  return Anchored{response.revision(), {SessionId(response.session()), response.index()}};
}

absl::StatusOr<int64_t> Client::RemoveAnchor(const SubmapId& submap) {
  v1::DeleteAnchorRequest request;
  request.set_session(submap.session.value());
  request.set_index(submap.index);
  v1::DeleteAnchorResponse response;
  // Not repeated: after a lost answer the second attempt would say that there is no such anchor.
  const absl::Status status = link_->CallOnce(
      link_->options().transfer_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.edits->DeleteAnchor(&context, request, &response);
      });
  if (!status.ok()) return status;
  return response.revision();
}

absl::Status Client::SetDatum(const std::optional<Datum>& datum) {
  v1::SetDatumRequest request;
  if (datum) *request.mutable_datum() = convert::ToMessage(*datum);
  v1::SetDatumResponse response;
  return link_->Call(link_->options().transfer_timeout_s,
                     [&](Stubs& stubs, grpc::ClientContext& context) {
                       return stubs.edits->SetDatum(&context, request, &response);
                     });
}

absl::StatusOr<int64_t> Client::UndoRevision(int64_t revision, const std::string& note) {
  v1::UndoRevisionRequest request;
  request.set_revision(revision);
  request.set_note(note);
  v1::UndoRevisionResponse response;
  // Not repeated: after a lost answer the second attempt would say that nothing is left to undo.
  const absl::Status status = link_->CallOnce(
      link_->options().transfer_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.edits->UndoRevision(&context, request, &response);
      });
  if (!status.ok()) return status;
  return response.revision();
}

absl::Status Client::DeleteSession(const SessionId& session) {
  v1::DeleteSessionRequest request;
  request.set_session(session.value());
  v1::DeleteSessionResponse response;
  // Not repeated: after a lost answer the second attempt would say that there is no such session.
  return link_->CallOnce(link_->options().call_timeout_s,
                         [&](Stubs& stubs, grpc::ClientContext& context) {
                           return stubs.edits->DeleteSession(&context, request, &response);
                         });
}

}  // namespace isthmus::client
