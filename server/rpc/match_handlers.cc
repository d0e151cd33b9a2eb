#include "server/rpc/match_handlers.h"

#include <map>
#include <optional>
#include <set>
#include <utility>

#include "server/rpc/convert.h"
#include "server/rpc/robots_of.h"

namespace isthmus::rpc {
namespace {

using rpc::ToProto;  // Else hidden by the overloads below.

v1::Match::State ToProto(MatchState state) {
  switch (state) {
    case MatchState::kAccepted:
      return v1::Match::ACCEPTED;
    case MatchState::kRejected:
      return v1::Match::REJECTED;
    case MatchState::kAmbiguous:
      return v1::Match::AMBIGUOUS;
    case MatchState::kNotYet:
      return v1::Match::NOT_YET;
  }
  return v1::Match::STATE_UNSPECIFIED;
}

v1::Match ToProto(const Match& match, const RobotOfSession& robots) {
  v1::Match proto;
  proto.set_session_a(match.a.value());
  proto.set_session_b(match.b.value());
  proto.set_robot_a(RobotOf(robots, match.a));
  proto.set_robot_b(RobotOf(robots, match.b));
  *proto.mutable_t_a_b() = ToProto(match.T_a_b);
  proto.set_state(ToProto(match.state));
  proto.set_reason(match.reason);
  proto.set_detail(match.detail);
  proto.set_confidence(match.confidence);
  proto.set_overlap(match.overlap);
  proto.set_inliers(match.inliers);
  proto.set_residual_m(match.residual_m);
  proto.set_free_space(match.free_space);
  proto.set_comparisons(match.comparisons);
  proto.set_runner_up(match.runner_up);
  proto.set_matcher(match.matcher);
  proto.set_inlier_ratio(match.inlier_ratio);
  proto.set_shared_area_m2(match.shared_area_m2);
  proto.set_hold(match.hold);
  proto.set_strain(match.strain);
  proto.set_cycle_m(match.cycle_m);
  proto.set_cycle_deg(match.cycle_deg);
  proto.set_candidates(match.candidates);
  proto.set_submaps_a(match.submaps_a);
  proto.set_submaps_b(match.submaps_b);
  proto.set_computed_ns(match.computed_ns);
  for (const StageTime& stage : match.stages) {
    v1::StageTime& time = *proto.add_stages();
    time.set_stage(stage.stage);
    time.set_ms(stage.ms);
  }
  return proto;
}

v1::Verdict::Ruling ToProto(Ruling ruling) {
  switch (ruling) {
    case Ruling::kAccept:
      return v1::Verdict::ACCEPT;
    case Ruling::kReject:
      return v1::Verdict::REJECT;
    case Ruling::kSet:
      return v1::Verdict::SET;
  }
  return v1::Verdict::RULING_UNSPECIFIED;
}

v1::Verdict ToProto(const Verdict& verdict) {
  v1::Verdict proto;
  proto.set_ruling(ToProto(verdict.ruling));
  proto.set_note(verdict.note);
  proto.set_given_ns(verdict.given_ns);
  return proto;
}

v1::Placement ToProto(const Placement& placement, const RobotOfSession& robots) {
  v1::Placement proto;
  proto.set_session(placement.session.value());
  proto.set_robot(RobotOf(robots, placement.session));
  proto.set_component(placement.component);
  proto.set_reference_session(placement.reference.value());
  *proto.mutable_t_map_odom() = ToProto(placement.T_map_odom);
  return proto;
}

// The ruling that is asked for; nothing for WITHDRAW.
absl::StatusOr<std::optional<Ruling>> FromProto(v1::DecideMatchRequest::Decision decision) {
  switch (decision) {
    case v1::DecideMatchRequest::ACCEPT:
      return Ruling::kAccept;
    case v1::DecideMatchRequest::REJECT:
      return Ruling::kReject;
    case v1::DecideMatchRequest::SET:
      return Ruling::kSet;
    case v1::DecideMatchRequest::WITHDRAW:
      return std::optional<Ruling>();
    default:
      return absl::InvalidArgumentError("name the decision: ACCEPT, REJECT, SET or WITHDRAW");
  }
}

}  // namespace

absl::StatusOr<v1::MatchGraph> GetMatchGraph(server::Pipeline& pipeline,
                                             const v1::GetMatchGraphRequest& request) {
  const server::MatchGraphView view = pipeline.GetMatchGraph();
  const RobotOfSession robots = RobotsOf(pipeline);
  std::set<std::pair<SessionId, SessionId>> tree;
  for (const auto& [a, b] : view.tree) tree.insert(std::minmax(a, b));
  v1::MatchGraph proto;
  proto.set_revision(view.revision);
  std::map<std::pair<SessionId, SessionId>, const Verdict*> verdicts;
  for (const Verdict& verdict : view.verdicts) verdicts[{verdict.a, verdict.b}] = &verdict;
  for (const Match& match : view.matches) {
    v1::Match& added = *proto.add_matches();
    added = ToProto(match, robots);
    added.set_in_tree(tree.contains(std::minmax(match.a, match.b)));
    if (request.include_edges()) {
      for (const SubmapEdge& edge : match.edges) *added.add_edges() = ToProto(edge);
    }
    const auto said = verdicts.find({match.a, match.b});
    if (said != verdicts.end()) *added.mutable_verdict() = ToProto(*said->second);
  }
  for (const Placement& placement : view.placements) {
    *proto.add_placements() = ToProto(placement, robots);
  }
  return proto;
}

absl::StatusOr<v1::DecideMatchResponse> DecideMatch(server::Pipeline& pipeline,
                                                    const v1::DecideMatchRequest& request) {
  server::MatchDecision decision;
  decision.robot_a = RobotId(request.robot_a());
  decision.robot_b = RobotId(request.robot_b());
  decision.session_a = SessionId(request.session_a());
  decision.session_b = SessionId(request.session_b());
  decision.note = request.note();
  const auto ruling = FromProto(request.decision());
  if (!ruling.ok()) return ruling.status();
  decision.ruling = *ruling;
  if (decision.ruling == Ruling::kSet) {
    if (!request.has_t_a_b()) {
      return absl::InvalidArgumentError("SET needs t_a_b, the pose of b's odom frame in a's");
    }
    const auto T_a_b = rpc::FromProto(request.t_a_b(), "t_a_b");
    if (!T_a_b.ok()) return T_a_b.status();
    decision.T_a_b = *T_a_b;
  }
  const absl::StatusOr<Match> match = pipeline.DecideMatch(decision);
  if (!match.ok()) return match.status();
  // From the graph as it is now, which tells what the match carries.
  const auto graph = GetMatchGraph(pipeline, {});
  if (!graph.ok()) return graph.status();
  v1::DecideMatchResponse response;
  response.set_revision(graph->revision());
  for (const v1::Match& edge : graph->matches()) {
    if (edge.session_a() != match->a.value() || edge.session_b() != match->b.value()) continue;
    *response.mutable_match() = edge;
    return response;
  }
  *response.mutable_match() = ToProto(*match, RobotsOf(pipeline));
  return response;
}

}  // namespace isthmus::rpc
