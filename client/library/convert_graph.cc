// Revisions, loop closures and anchors.
#include <string>
#include <utility>

#include "client/library/convert.h"

namespace isthmus::client {

SubmapEdge FromProto(const v1::SubmapEdge& edge) {
  SubmapEdge out;
  out.submap_a = edge.submap_a();
  out.submap_b = edge.submap_b();
  out.T_a_b = FromProto(edge.t_a_b());
  out.information = FromUpperTriangle(edge.information()).value_or(Matrix6d::Zero());
  return out;
}

RevisionInfo FromProto(const v1::Revision& revision) {
  RevisionInfo out;
  out.revision = revision.revision();
  out.stamp_ns = revision.stamp_ns();
  out.cause = revision.cause();
  for (const v1::SessionPair& pair : revision.matches()) {
    out.matches.emplace_back(SessionId(pair.session_a()), SessionId(pair.session_b()));
  }
  out.loops.assign(revision.loops().begin(), revision.loops().end());
  out.added = revision.added();
  out.moved = revision.moved();
  out.removed = revision.removed();
  out.largest_move_m = revision.largest_move_m();
  return out;
}

SubmapMove FromProto(const v1::SubmapMove& move) {
  SubmapMove out;
  out.submap = {SessionId(move.session()), move.index()};
  if (move.has_before()) out.before = FromProto(move.before());
  out.frame_before = SessionId(move.reference_before());
  if (move.has_after()) out.after = FromProto(move.after());
  out.frame_after = SessionId(move.reference_after());
  return out;
}

Loop FromProto(const v1::Loop& loop) {
  Loop out;
  LoopClosure& l = out.loop;
  l.id = loop.id();
  l.session = SessionId(loop.session());
  l.submap_a = loop.submap_a();
  l.submap_b = loop.submap_b();
  l.T_a_b = FromProto(loop.t_a_b());
  l.confidence = loop.confidence();
  l.overlap = loop.overlap();
  l.residual_m = loop.residual_m();
  l.free_space = loop.free_space();
  l.comparisons = loop.comparisons();
  l.source = loop.source();
  l.detail = loop.detail();
  l.computed_ns = loop.computed_ns();
  l.rejected = loop.rejected();
  l.note = loop.note();
  for (const v1::SubmapEdge& edge : loop.edges()) l.edges.push_back(FromProto(edge));
  out.robot = RobotId(loop.robot());
  out.edge_count = loop.edge_count();
  out.edges_used = loop.edges_used();
  return out;
}

v1::DecideLoopRequest ToProto(const LoopDecision& decision) {
  v1::DecideLoopRequest out;
  out.set_id(decision.id);
  out.set_decision(decision.rejected ? v1::DecideLoopRequest::REJECT
                                     : v1::DecideLoopRequest::RESTORE);
  out.set_note(decision.note);
  return out;
}

v1::Anchor ToProto(const Anchor& anchor) {
  v1::Anchor out;
  out.set_session(anchor.submap.session.value());
  out.set_index(anchor.submap.index);
  *out.mutable_t_map_submap() = ToProto(anchor.T_map_submap);
  out.set_sigma_xy_m(anchor.sigma_xy_m);
  out.set_sigma_z_m(anchor.sigma_z_m);
  out.set_sigma_deg(anchor.sigma_deg);
  out.set_note(anchor.note);
  return out;
}

RobotAnchor FromProto(const v1::Anchor& anchor) {
  RobotAnchor out;
  Anchor& a = out.anchor;
  a.submap = {SessionId(anchor.session()), anchor.index()};
  a.T_map_submap = FromProto(anchor.t_map_submap());
  a.sigma_xy_m = anchor.sigma_xy_m();
  a.sigma_z_m = anchor.sigma_z_m();
  a.sigma_deg = anchor.sigma_deg();
  a.note = anchor.note();
  a.given_ns = anchor.given_ns();
  out.robot = RobotId(anchor.robot());
  return out;
}

}  // namespace isthmus::client
