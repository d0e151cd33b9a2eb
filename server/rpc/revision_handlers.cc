#include "server/rpc/revision_handlers.h"

#include <algorithm>

#include "core/note.h"
#include "server/rpc/convert.h"

namespace isthmus::rpc {
namespace {

using rpc::ToProto;  // Else hidden by the overloads below.

constexpr uint32_t kDefaultRevisions = 100, kMaxRevisions = 10'000;  // As the API says.
constexpr size_t kMovesChunk = 1000;                                 // In a response.

v1::Revision ToProto(const RevisionInfo& info) {
  v1::Revision proto;
  proto.set_revision(info.revision);
  proto.set_stamp_ns(info.stamp_ns);
  proto.set_cause(info.cause);
  for (const auto& [a, b] : info.matches) {
    v1::SessionPair& pair = *proto.add_matches();
    pair.set_session_a(a.value());
    pair.set_session_b(b.value());
  }
  for (const uint64_t loop : info.loops) proto.add_loops(loop);
  proto.set_added(info.added);
  proto.set_moved(info.moved);
  proto.set_removed(info.removed);
  proto.set_largest_move_m(info.largest_move_m);
  return proto;
}

v1::SubmapMove ToProto(const SubmapMove& move) {
  v1::SubmapMove proto;
  proto.set_session(move.submap.session.value());
  proto.set_index(move.submap.index);
  if (move.before) {
    *proto.mutable_before() = ToProto(*move.before);
    proto.set_reference_before(move.frame_before.value());
  }
  if (move.after) {
    *proto.mutable_after() = ToProto(*move.after);
    proto.set_reference_after(move.frame_after.value());
  }
  return proto;
}

}  // namespace

absl::StatusOr<v1::ListRevisionsResponse> ListRevisions(server::Pipeline& pipeline,
                                                        const v1::ListRevisionsRequest& request) {
  const uint32_t limit = request.limit() == 0 ? kDefaultRevisions : request.limit();
  const auto revisions = pipeline.ListRevisions(static_cast<int>(std::min(limit, kMaxRevisions)));
  if (!revisions.ok()) return revisions.status();
  v1::ListRevisionsResponse response;
  for (const RevisionInfo& info : *revisions) *response.add_revisions() = ToProto(info);
  // Of the list itself, so that the two cannot differ.
  if (!revisions->empty()) response.set_revision(revisions->front().revision);
  return response;
}

absl::Status DiffRevisions(server::Pipeline& pipeline, const v1::DiffRevisionsRequest& request,
                           const Emit<v1::DiffRevisionsResponse>& emit) {
  if (request.from_revision() < 0 || request.to_revision() < 0) {
    return absl::InvalidArgumentError("revisions are counted from 0, the empty map");
  }
  const auto diff = pipeline.DiffRevisions(request.from_revision(), request.to_revision());
  if (!diff.ok()) return diff.status();
  size_t sent = 0;
  do {  // At least one response, so that the revisions are named also where nothing moved.
    v1::DiffRevisionsResponse response;
    response.set_from_revision(diff->from);
    response.set_to_revision(diff->to);
    if (sent == 0) {
      for (const RevisionInfo& info : diff->revisions) *response.add_revisions() = ToProto(info);
    }
    const size_t end = std::min(sent + kMovesChunk, diff->moves.size());
    for (; sent < end; ++sent) *response.add_moves() = ToProto(diff->moves[sent]);
    if (!emit(response)) return ReaderGone();
  } while (sent < diff->moves.size());
  return absl::OkStatus();
}

absl::StatusOr<v1::UndoRevisionResponse> UndoRevision(server::Pipeline& pipeline,
                                                      const v1::UndoRevisionRequest& request) {
  if (absl::Status status = CheckNote(request.note()); !status.ok()) return status;
  const auto revision = pipeline.UndoRevision(request.revision(), request.note());
  if (!revision.ok()) return revision.status();
  v1::UndoRevisionResponse response;
  response.set_revision(*revision);
  return response;
}

}  // namespace isthmus::rpc
