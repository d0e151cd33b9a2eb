// Loop closures, anchors, revisions and backups.
#include "api/convert/graph.h"

#include <absl/strings/str_cat.h>

#include <cmath>

#include "api/convert/enum_table.h"
#include "api/convert/geometry.h"
#include "api/convert/guess_sources.h"

namespace isthmus::convert {
namespace {

absl::Status CheckSigma(double sigma, const char* name) {
  if (std::isfinite(sigma) && sigma >= 0) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(name, " is ", sigma, ": give a standard deviation, or 0 if it is unknown"));
}

}  // namespace

v1::SubmapEdge ToMessage(const SubmapEdge& edge) {
  v1::SubmapEdge message;
  message.set_submap_a(edge.submap_a);
  message.set_submap_b(edge.submap_b);
  *message.mutable_t_a_b() = ToMessage(edge.T_a_b);
  AddUpperTriangle(edge.information, message.mutable_information());
  return message;
}

SubmapEdge FromMessage(const v1::SubmapEdge& message) {
  SubmapEdge edge;
  edge.submap_a = message.submap_a();
  edge.submap_b = message.submap_b();
  edge.T_a_b = FromMessage(message.t_a_b());
  edge.information = FromUpperTriangle(message.information()).value_or(Matrix6d::Zero());
  return edge;
}

v1::Loop ToMessage(const Loop& told) {
  const LoopClosure& loop = told.loop;
  v1::Loop message;
  message.set_id(loop.id);
  message.set_session(loop.session.value());
  message.set_robot(told.robot.value());
  message.set_submap_a(loop.submap_a);
  message.set_submap_b(loop.submap_b);
  *message.mutable_t_a_b() = ToMessage(loop.T_a_b);
  message.set_confidence(loop.confidence);
  message.set_overlap(loop.overlap);
  message.set_residual_m(loop.residual_m);
  message.set_free_space(loop.free_space);
  message.set_comparisons(loop.comparisons);
  message.set_source(ToMessage(kGuessSources, loop.source));
  message.set_detail(loop.detail);
  message.set_computed_ns(loop.computed_ns);
  message.set_rejected(loop.rejected);
  message.set_note(loop.note);
  message.set_edge_count(told.edge_count);
  message.set_edges_used(told.edges_used);
  return message;
}

Loop FromMessage(const v1::Loop& message) {
  Loop told;
  LoopClosure& loop = told.loop;
  loop.id = message.id();
  loop.session = SessionId(message.session());
  loop.submap_a = message.submap_a();
  loop.submap_b = message.submap_b();
  loop.T_a_b = FromMessage(message.t_a_b());
  loop.confidence = message.confidence();
  loop.overlap = message.overlap();
  loop.residual_m = message.residual_m();
  loop.free_space = message.free_space();
  loop.comparisons = message.comparisons();
  loop.source = FromMessage(kGuessSources, message.source(), GuessSource::kNone);
  loop.detail = message.detail();
  loop.computed_ns = message.computed_ns();
  loop.rejected = message.rejected();
  loop.note = message.note();
  for (const v1::SubmapEdge& edge : message.edges()) loop.edges.push_back(FromMessage(edge));
  told.robot = RobotId(message.robot());
  told.edge_count = message.edge_count();
  told.edges_used = message.edges_used();
  return told;
}

v1::DecideLoopRequest ToMessage(const LoopDecision& decision) {
  v1::DecideLoopRequest message;
  message.set_id(decision.id);
  message.set_decision(decision.rejected ? v1::DecideLoopRequest::REJECT
                                         : v1::DecideLoopRequest::RESTORE);
  message.set_note(decision.note);
  return message;
}

absl::StatusOr<LoopDecision> FromMessage(const v1::DecideLoopRequest& request) {
  const bool rejected = request.decision() == v1::DecideLoopRequest::REJECT;
  if (!rejected && request.decision() != v1::DecideLoopRequest::RESTORE) {
    return absl::InvalidArgumentError("name the decision: REJECT or RESTORE");
  }
  return LoopDecision{request.id(), rejected, request.note()};
}

v1::Anchor ToMessage(const RobotAnchor& told) {
  const Anchor& anchor = told.anchor;
  v1::Anchor message;
  message.set_session(anchor.submap.session.value());
  message.set_index(anchor.submap.index);
  message.set_robot(told.robot.value());
  *message.mutable_t_map_submap() = ToMessage(anchor.T_map_submap);
  message.set_sigma_xy_m(anchor.sigma_xy_m);
  message.set_sigma_z_m(anchor.sigma_z_m);
  message.set_sigma_deg(anchor.sigma_deg);
  message.set_note(anchor.note);
  message.set_given_ns(anchor.given_ns);
  return message;
}

RobotAnchor FromMessage(const v1::Anchor& message) {
  RobotAnchor told;
  Anchor& anchor = told.anchor;
  anchor.submap = {SessionId(message.session()), message.index()};
  anchor.T_map_submap = FromMessage(message.t_map_submap());
  anchor.sigma_xy_m = message.sigma_xy_m();
  anchor.sigma_z_m = message.sigma_z_m();
  anchor.sigma_deg = message.sigma_deg();
  anchor.note = message.note();
  anchor.given_ns = message.given_ns();
  told.robot = RobotId(message.robot());
  return told;
}

absl::StatusOr<Anchor> Checked(const v1::Anchor& message) {
  if (!message.has_t_map_submap()) {
    return absl::InvalidArgumentError("an anchor needs t_map_submap, the place of the submap");
  }
  const auto pose = Checked(message.t_map_submap(), "t_map_submap");
  absl::Status status = pose.status();
  if (status.ok()) status = CheckSigma(message.sigma_xy_m(), "sigma_xy_m");
  if (status.ok()) status = CheckSigma(message.sigma_z_m(), "sigma_z_m");
  if (status.ok()) status = CheckSigma(message.sigma_deg(), "sigma_deg");
  if (!status.ok()) return status;
  Anchor anchor = FromMessage(message).anchor;
  anchor.T_map_submap = *pose;
  anchor.given_ns = 0;
  return anchor;
}

v1::Revision ToMessage(const RevisionInfo& info) {
  v1::Revision message;
  message.set_revision(info.revision);
  message.set_stamp_ns(info.stamp_ns);
  message.set_cause(info.cause);
  for (const auto& [a, b] : info.matches) {
    v1::SessionPair& pair = *message.add_matches();
    pair.set_session_a(a.value());
    pair.set_session_b(b.value());
  }
  for (const uint64_t loop : info.loops) message.add_loops(loop);
  message.set_added(info.added);
  message.set_moved(info.moved);
  message.set_removed(info.removed);
  message.set_largest_move_m(info.largest_move_m);
  return message;
}

RevisionInfo FromMessage(const v1::Revision& revision) {
  RevisionInfo info;
  info.revision = revision.revision();
  info.stamp_ns = revision.stamp_ns();
  info.cause = revision.cause();
  for (const v1::SessionPair& pair : revision.matches()) {
    info.matches.emplace_back(SessionId(pair.session_a()), SessionId(pair.session_b()));
  }
  info.loops.assign(revision.loops().begin(), revision.loops().end());
  info.added = revision.added();
  info.moved = revision.moved();
  info.removed = revision.removed();
  info.largest_move_m = revision.largest_move_m();
  return info;
}

v1::SubmapMove ToMessage(const SubmapMove& move) {
  v1::SubmapMove message;
  message.set_session(move.submap.session.value());
  message.set_index(move.submap.index);
  if (move.before) {
    *message.mutable_before() = ToMessage(*move.before);
    message.set_reference_before(move.frame_before.value());
  }
  if (move.after) {
    *message.mutable_after() = ToMessage(*move.after);
    message.set_reference_after(move.frame_after.value());
  }
  return message;
}

SubmapMove FromMessage(const v1::SubmapMove& message) {
  SubmapMove move;
  move.submap = {SessionId(message.session()), message.index()};
  if (message.has_before()) move.before = FromMessage(message.before());
  move.frame_before = SessionId(message.reference_before());
  if (message.has_after()) move.after = FromMessage(message.after());
  move.frame_after = SessionId(message.reference_after());
  return move;
}

v1::BackupContents ToMessage(const BackupContents& contents) {
  v1::BackupContents message;
  message.set_sessions(contents.sessions);
  message.set_submaps(contents.submaps);
  message.set_scans(contents.scans);
  message.set_points(contents.points);
  message.set_damaged(contents.damaged);
  message.set_report(contents.report);
  return message;
}

BackupContents FromMessage(const v1::BackupContents& message) {
  return {message.sessions(), message.submaps(), message.scans(),
          message.points(),   message.damaged(), message.report()};
}

}  // namespace isthmus::convert
