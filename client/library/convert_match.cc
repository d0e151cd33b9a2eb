// The match graph and a person's word on it.
#include <string>
#include <utility>

#include "client/library/convert.h"

namespace isthmus::client {
namespace {

MatchState ToState(v1::Match::State state) {
  switch (state) {
    case v1::Match::ACCEPTED:
      return MatchState::kAccepted;
    case v1::Match::REJECTED:
      return MatchState::kRejected;
    case v1::Match::AMBIGUOUS:
      return MatchState::kAmbiguous;
    default:
      return MatchState::kNotYet;
  }
}

Ruling ToRuling(v1::Verdict::Ruling ruling) {
  if (ruling == v1::Verdict::ACCEPT) return Ruling::kAccept;
  return ruling == v1::Verdict::SET ? Ruling::kSet : Ruling::kReject;
}

}  // namespace

v1::DecideMatchRequest ToProto(const MatchDecision& decision) {
  v1::DecideMatchRequest out;
  out.set_robot_a(decision.robot_a.value());
  out.set_robot_b(decision.robot_b.value());
  out.set_session_a(decision.session_a.value());
  out.set_session_b(decision.session_b.value());
  out.set_note(decision.note);
  out.set_decision(v1::DecideMatchRequest::WITHDRAW);
  if (!decision.ruling) return out;
  switch (*decision.ruling) {
    case Ruling::kAccept:
      out.set_decision(v1::DecideMatchRequest::ACCEPT);
      break;
    case Ruling::kReject:
      out.set_decision(v1::DecideMatchRequest::REJECT);
      break;
    case Ruling::kSet:
      out.set_decision(v1::DecideMatchRequest::SET);
      *out.mutable_t_a_b() = ToProto(decision.T_a_b);
      break;
  }
  return out;
}

MatchEdge FromProto(const v1::Match& match) {
  MatchEdge out;
  Match& m = out.match;
  m.a = SessionId(match.session_a());
  m.b = SessionId(match.session_b());
  m.T_a_b = FromProto(match.t_a_b());
  m.state = ToState(match.state());
  m.reason = match.reason();
  m.detail = match.detail();
  m.confidence = match.confidence();
  m.overlap = match.overlap();
  m.inliers = match.inliers();
  m.residual_m = match.residual_m();
  m.free_space = match.free_space();
  m.comparisons = match.comparisons();
  m.runner_up = match.runner_up();
  m.matcher = match.matcher();
  m.inlier_ratio = match.inlier_ratio();
  m.shared_area_m2 = match.shared_area_m2();
  m.hold = match.hold();
  m.strain = match.strain();
  m.cycle_m = match.cycle_m();
  m.cycle_deg = match.cycle_deg();
  m.candidates = match.candidates();
  m.submaps_a = match.submaps_a();
  m.submaps_b = match.submaps_b();
  m.computed_ns = match.computed_ns();
  for (const v1::StageTime& stage : match.stages()) m.stages.push_back({stage.stage(), stage.ms()});
  for (const v1::SubmapEdge& edge : match.edges()) m.edges.push_back(FromProto(edge));
  out.robot_a = RobotId(match.robot_a());
  out.robot_b = RobotId(match.robot_b());
  out.in_tree = match.in_tree();
  if (match.has_verdict()) {
    const v1::Verdict& said = match.verdict();
    out.verdict = Verdict{m.a, m.b, ToRuling(said.ruling()), m.T_a_b, said.note(), said.given_ns()};
  }
  return out;
}

MatchGraph FromProto(const v1::MatchGraph& graph) {
  MatchGraph out;
  out.revision = graph.revision();
  for (const v1::Match& match : graph.matches()) out.matches.push_back(FromProto(match));
  for (const v1::Placement& placement : graph.placements()) {
    PlacedSession placed;
    placed.placement.session = SessionId(placement.session());
    placed.placement.component = placement.component();
    placed.placement.reference = SessionId(placement.reference_session());
    placed.placement.T_map_odom = FromProto(placement.t_map_odom());
    placed.robot = RobotId(placement.robot());
    out.placements.push_back(std::move(placed));
  }
  return out;
}

}  // namespace isthmus::client
