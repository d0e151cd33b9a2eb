#include "server/rpc/loop_handlers.h"

#include <optional>

#include "core/note.h"
#include "server/rpc/convert.h"
#include "server/rpc/robots_of.h"

namespace isthmus::rpc {
namespace {

using rpc::ToProto;  // Else hidden by the overload below.

// Without its edges.
v1::Loop ToProto(const server::LoopStatus& status, const RobotOfSession& robots) {
  const LoopClosure& loop = status.loop;
  v1::Loop proto;
  proto.set_id(loop.id);
  proto.set_session(loop.session.value());
  proto.set_robot(RobotOf(robots, loop.session));
  proto.set_submap_a(loop.submap_a);
  proto.set_submap_b(loop.submap_b);
  *proto.mutable_t_a_b() = ToProto(loop.T_a_b);
  proto.set_confidence(loop.confidence);
  proto.set_overlap(loop.overlap);
  proto.set_residual_m(loop.residual_m);
  proto.set_free_space(loop.free_space);
  proto.set_comparisons(loop.comparisons);
  proto.set_source(loop.source);
  proto.set_detail(loop.detail);
  proto.set_computed_ns(loop.computed_ns);
  proto.set_rejected(loop.rejected);
  proto.set_note(loop.note);
  proto.set_edge_count(static_cast<uint32_t>(loop.edges.size()));
  proto.set_edges_used(status.edges_used);
  return proto;
}

}  // namespace

absl::StatusOr<v1::ListLoopsResponse> ListLoops(server::Pipeline& pipeline,
                                                const v1::ListLoopsRequest& request) {
  std::optional<RobotId> robot;
  if (!request.robot().empty()) robot = RobotId(request.robot());
  v1::ListLoopsResponse response;
  response.set_revision(pipeline.GetMapInfo().revision);
  const auto loops = pipeline.ListLoops(robot);
  if (!loops.ok()) return loops.status();
  const RobotOfSession robots = RobotsOf(pipeline);
  for (const server::LoopStatus& status : *loops) {
    v1::Loop& added = *response.add_loops();
    added = ToProto(status, robots);
    if (!request.include_edges()) continue;
    for (const SubmapEdge& edge : status.loop.edges) *added.add_edges() = ToProto(edge);
  }
  return response;
}

absl::StatusOr<v1::DecideLoopResponse> DecideLoop(server::Pipeline& pipeline,
                                                  const v1::DecideLoopRequest& request) {
  const bool rejected = request.decision() == v1::DecideLoopRequest::REJECT;
  if (!rejected && request.decision() != v1::DecideLoopRequest::RESTORE) {
    return absl::InvalidArgumentError("name the decision: REJECT or RESTORE");
  }
  if (absl::Status status = CheckNote(request.note()); !status.ok()) return status;
  const auto loop = pipeline.DecideLoop({request.id(), rejected, request.note()});
  if (!loop.ok()) return loop.status();
  v1::DecideLoopResponse response;
  response.set_revision(pipeline.GetMapInfo().revision);
  *response.mutable_loop() = ToProto(*loop, RobotsOf(pipeline));
  return response;
}

}  // namespace isthmus::rpc
