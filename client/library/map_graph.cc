// The part of Client about where submaps lie: revisions, loop closures and anchors.
#include <algorithm>
#include <string>

#include "client/library/client.h"
#include "client/library/convert.h"
#include "client/library/link.h"

namespace isthmus::client {

using Stubs = Client::Link::Stubs;

absl::StatusOr<std::vector<RevisionInfo>> Client::ListRevisions(int limit) {
  v1::ListRevisionsRequest request;
  request.set_limit(static_cast<uint32_t>(std::max(limit, 0)));
  v1::ListRevisionsResponse response;
  const absl::Status status =
      link_->Call(link_->options().call_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.graph->ListRevisions(&context, request, &response);
      });
  if (!status.ok()) return status;
  std::vector<RevisionInfo> revisions;
  for (const v1::Revision& revision : response.revisions()) {
    revisions.push_back(FromProto(revision));
  }
  return revisions;
}

absl::StatusOr<RevisionDiff> Client::DiffRevisions(int64_t from, int64_t to) {
  v1::DiffRevisionsRequest request;
  request.set_from_revision(from);
  request.set_to_revision(to);
  RevisionDiff diff;
  const auto read = [&](Stubs& stubs, grpc::ClientContext& context) {
    diff = {};
    auto reader = stubs.graph->DiffRevisions(&context, request);
    v1::DiffRevisionsResponse part;
    while (reader->Read(&part)) {
      diff.from = part.from_revision();
      diff.to = part.to_revision();
      for (const v1::Revision& revision : part.revisions()) {
        diff.revisions.push_back(FromProto(revision));
      }
      for (const v1::SubmapMove& move : part.moves()) diff.moves.push_back(FromProto(move));
    }
    return reader->Finish();
  };
  const absl::Status status = link_->Call(link_->options().transfer_timeout_s, read);
  if (!status.ok()) return status;
  return diff;
}

absl::StatusOr<int64_t> Client::UndoRevision(int64_t revision, const std::string& note) {
  v1::UndoRevisionRequest request;
  request.set_revision(revision);
  request.set_note(note);
  v1::UndoRevisionResponse response;
  // Not repeated: after a lost answer the second attempt would say that nothing is left to undo.
  const absl::Status status = link_->CallOnce(
      link_->options().transfer_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.graph->UndoRevision(&context, request, &response);
      });
  if (!status.ok()) return status;
  return response.revision();
}

absl::StatusOr<std::vector<Loop>> Client::ListLoops(const RobotId& robot, bool include_edges) {
  v1::ListLoopsRequest request;
  request.set_robot(robot.value());
  request.set_include_edges(include_edges);
  v1::ListLoopsResponse response;
  const absl::Status status =
      link_->Call(link_->options().call_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.graph->ListLoops(&context, request, &response);
      });
  if (!status.ok()) return status;
  std::vector<Loop> loops;
  for (const v1::Loop& loop : response.loops()) loops.push_back(FromProto(loop));
  return loops;
}

absl::StatusOr<Loop> Client::DecideLoop(const LoopDecision& decision) {
  const v1::DecideLoopRequest request = ToProto(decision);
  v1::DecideLoopResponse response;
  // May be repeated: the same decision twice is one.
  const absl::Status status = link_->Call(
      link_->options().transfer_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.graph->DecideLoop(&context, request, &response);
      });
  if (!status.ok()) return status;
  return FromProto(response.loop());
}

absl::StatusOr<Anchored> Client::PutAnchor(const Anchor& anchor, const RobotId& robot) {
  v1::PutAnchorRequest request;
  *request.mutable_anchor() = ToProto(anchor);
  request.set_robot(robot.value());
  v1::PutAnchorResponse response;
  const auto put = [&](Stubs& stubs, grpc::ClientContext& context) {
    return stubs.graph->PutAnchor(&context, request, &response);
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
        return stubs.graph->DeleteAnchor(&context, request, &response);
      });
  if (!status.ok()) return status;
  return response.revision();
}

absl::StatusOr<std::vector<RobotAnchor>> Client::ListAnchors() {
  v1::ListAnchorsResponse response;
  const absl::Status status =
      link_->Call(link_->options().call_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.graph->ListAnchors(&context, v1::ListAnchorsRequest(), &response);
      });
  if (!status.ok()) return status;
  std::vector<RobotAnchor> anchors;
  for (const v1::Anchor& anchor : response.anchors()) anchors.push_back(FromProto(anchor));
  return anchors;
}

}  // namespace isthmus::client
