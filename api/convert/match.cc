// The match graph, and a person's decision on it.
#include <optional>
#include <utility>

#include "api/convert/enum_table.h"
#include "api/convert/geometry.h"
#include "api/convert/graph.h"
#include "api/convert/guess_sources.h"

namespace isthmus::convert {
namespace {

constexpr std::pair<MatchState, v1::Match::State> kStates[] = {
    {MatchState::kAccepted, v1::Match::ACCEPTED},
    {MatchState::kRejected, v1::Match::REJECTED},
    {MatchState::kAmbiguous, v1::Match::AMBIGUOUS},
    {MatchState::kNotYet, v1::Match::NOT_YET},
};

constexpr std::pair<MatchReason, v1::Match::Reason> kReasons[] = {
    {MatchReason::kNone, v1::Match::REASON_UNSPECIFIED},
    {MatchReason::kOk, v1::Match::REASON_OK},
    {MatchReason::kByHand, v1::Match::REASON_BY_HAND},
    {MatchReason::kFreeSpace, v1::Match::REASON_FREE_SPACE},
    {MatchReason::kPossibleTwin, v1::Match::REASON_POSSIBLE_TWIN},
    {MatchReason::kAmbiguous, v1::Match::REASON_AMBIGUOUS},
    {MatchReason::kCycle, v1::Match::REASON_CYCLE},
    {MatchReason::kGroup, v1::Match::REASON_GROUP},
    {MatchReason::kLowOverlap, v1::Match::REASON_LOW_OVERLAP},
    {MatchReason::kLoose, v1::Match::REASON_LOOSE},
    {MatchReason::kTooSmall, v1::Match::REASON_TOO_SMALL},
    {MatchReason::kFewComparisons, v1::Match::REASON_FEW_COMPARISONS},
    {MatchReason::kDegenerate, v1::Match::REASON_DEGENERATE},
    {MatchReason::kStrained, v1::Match::REASON_STRAINED},
    {MatchReason::kNotConverged, v1::Match::REASON_NOT_CONVERGED},
    {MatchReason::kNoCandidate, v1::Match::REASON_NO_CANDIDATE},
    {MatchReason::kNoPoses, v1::Match::REASON_NO_POSES},
    {MatchReason::kUnverified, v1::Match::REASON_UNVERIFIED},
};

constexpr std::pair<ManualDecisionKind, v1::ManualDecision::Kind> kDecisionKinds[] = {
    {ManualDecisionKind::kAccept, v1::ManualDecision::ACCEPT},
    {ManualDecisionKind::kReject, v1::ManualDecision::REJECT},
    {ManualDecisionKind::kSet, v1::ManualDecision::SET},
};

using Decided = std::optional<ManualDecisionKind>;  // Nothing: withdrawn.
constexpr std::pair<Decided, v1::DecideMatchRequest::Decision> kDecisions[] = {
    {ManualDecisionKind::kAccept, v1::DecideMatchRequest::ACCEPT},
    {ManualDecisionKind::kReject, v1::DecideMatchRequest::REJECT},
    {ManualDecisionKind::kSet, v1::DecideMatchRequest::SET},
    {std::nullopt, v1::DecideMatchRequest::WITHDRAW},
};

void AddManualDecision(const ManualDecision& manual_decision, v1::Match& message) {
  message.mutable_manual_decision()->set_kind(ToMessage(kDecisionKinds, manual_decision.kind));
  message.mutable_manual_decision()->set_note(manual_decision.note);
  message.mutable_manual_decision()->set_given_ns(manual_decision.given_ns);
}

ManualDecision ManualDecisionOf(const v1::ManualDecision& manual_decision, const Match& match) {
  return {match.a,
          match.b,
          FromMessage(kDecisionKinds, manual_decision.kind(), ManualDecisionKind::kReject),
          match.T_a_b,
          manual_decision.note(),
          manual_decision.given_ns()};
}

void AddDrive(const RobotDrive& drive, v1::Match& message) {
  v1::AskedDrive& added = *message.add_asked_drives();
  added.set_robot(drive.robot.value());
  added.set_session(drive.session.value());
  *added.mutable_t_a_b() = ToMessage(drive.T_a_b);
  for (const Eigen::Vector3d& point : drive.way) *added.add_way() = ToMessage(point);
  added.set_leaves_own(drive.leaves_own);
  added.set_length_m(drive.length_m);
  added.set_confidence(drive.confidence);
}

RobotDrive DriveOf(const v1::AskedDrive& message) {
  RobotDrive drive{.robot = RobotId(message.robot()),
                   .session = SessionId(message.session()),
                   .T_a_b = FromMessage(message.t_a_b()),
                   .way = {},
                   .leaves_own = message.leaves_own(),
                   .length_m = message.length_m(),
                   .confidence = message.confidence()};
  for (const v1::Vector3& point : message.way()) drive.way.push_back(FromMessage(point));
  return drive;
}

void AddFigures(const Match& match, v1::Match& message) {
  message.set_confidence(match.confidence);
  message.set_overlap(match.overlap);
  message.set_inliers(match.inliers);
  message.set_inlier_ratio(match.inlier_ratio);
  message.set_residual_m(match.residual_m);
  message.set_free_space(match.free_space);
  message.set_comparisons(match.comparisons);
  message.set_runner_up(match.runner_up);
  message.set_shared_area_m2(match.shared_area_m2);
  message.set_observability(match.observability);
  message.set_odometry_residual(match.odometry_residual);
  message.set_cycle_m(match.cycle_m);
  message.set_cycle_deg(match.cycle_deg);
  message.set_candidates(match.candidates);
  message.set_submaps_a(match.submaps_a);
  message.set_submaps_b(match.submaps_b);
}

void ReadFigures(const v1::Match& message, Match& match) {
  match.confidence = message.confidence();
  match.overlap = message.overlap();
  match.inliers = message.inliers();
  match.inlier_ratio = message.inlier_ratio();
  match.residual_m = message.residual_m();
  match.free_space = message.free_space();
  match.comparisons = message.comparisons();
  match.runner_up = message.runner_up();
  match.shared_area_m2 = message.shared_area_m2();
  match.observability = message.observability();
  match.odometry_residual = message.odometry_residual();
  match.cycle_m = message.cycle_m();
  match.cycle_deg = message.cycle_deg();
  match.candidates = message.candidates();
  match.submaps_a = message.submaps_a();
  match.submaps_b = message.submaps_b();
}

}  // namespace

v1::Match ToMessage(const MatchEdge& edge) {
  const Match& match = edge.match;
  v1::Match message;
  message.set_session_a(match.a.value());
  message.set_session_b(match.b.value());
  message.set_robot_a(edge.robot_a.value());
  message.set_robot_b(edge.robot_b.value());
  *message.mutable_t_a_b() = ToMessage(match.T_a_b);
  message.set_state(ToMessage(kStates, match.state));
  message.set_reason(ToMessage(kReasons, match.reason));
  message.set_detail(match.detail);
  message.set_matcher(ToMessage(kGuessSources, match.matcher));
  message.set_computed_ns(match.computed_ns);
  AddFigures(match, message);
  for (const StageTime& stage : match.stages) {
    v1::StageTime& added = *message.add_stages();
    added.set_stage(stage.stage);
    added.set_ms(stage.ms);
  }
  message.set_in_tree(edge.in_tree);
  if (edge.manual_decision) AddManualDecision(*edge.manual_decision, message);
  for (const RobotDrive& drive : edge.asked_drives) AddDrive(drive, message);
  return message;
}

MatchEdge FromMessage(const v1::Match& message) {
  MatchEdge edge;
  Match& match = edge.match;
  match.a = SessionId(message.session_a());
  match.b = SessionId(message.session_b());
  edge.robot_a = RobotId(message.robot_a());
  edge.robot_b = RobotId(message.robot_b());
  match.T_a_b = FromMessage(message.t_a_b());
  match.state = FromMessage(kStates, message.state(), MatchState::kNotYet);
  match.reason = FromMessage(kReasons, message.reason(), MatchReason::kNone);
  match.detail = message.detail();
  match.matcher = FromMessage(kGuessSources, message.matcher(), GuessSource::kNone);
  match.computed_ns = message.computed_ns();
  ReadFigures(message, match);
  for (const v1::StageTime& stage : message.stages()) {
    match.stages.push_back({stage.stage(), stage.ms()});
  }
  for (const v1::SubmapEdge& added : message.edges()) match.edges.push_back(FromMessage(added));
  edge.in_tree = message.in_tree();
  if (message.has_manual_decision())
    edge.manual_decision = ManualDecisionOf(message.manual_decision(), match);
  for (const v1::AskedDrive& drive : message.asked_drives()) {
    edge.asked_drives.push_back(DriveOf(drive));
  }
  return edge;
}

v1::Placement ToMessage(const PlacedSession& placed) {
  v1::Placement message;
  message.set_session(placed.placement.session.value());
  message.set_robot(placed.robot.value());
  message.set_component(placed.placement.component);
  message.set_reference_session(placed.placement.reference.value());
  *message.mutable_t_map_odom() = ToMessage(placed.placement.T_map_odom);
  return message;
}

PlacedSession FromMessage(const v1::Placement& placement) {
  PlacedSession placed;
  placed.placement.session = SessionId(placement.session());
  placed.placement.component = placement.component();
  placed.placement.reference = SessionId(placement.reference_session());
  placed.placement.T_map_odom = FromMessage(placement.t_map_odom());
  placed.robot = RobotId(placement.robot());
  return placed;
}

v1::DecideMatchRequest ToMessage(const MatchDecision& decision) {
  v1::DecideMatchRequest message;
  message.set_robot_a(decision.robot_a.value());
  message.set_robot_b(decision.robot_b.value());
  message.set_session_a(decision.session_a.value());
  message.set_session_b(decision.session_b.value());
  message.set_note(decision.note);
  message.set_decision(ToMessage(kDecisions, decision.kind));
  if (decision.kind == ManualDecisionKind::kSet)
    *message.mutable_t_a_b() = ToMessage(decision.T_a_b);
  return message;
}

absl::StatusOr<MatchDecision> FromMessage(const v1::DecideMatchRequest& request) {
  MatchDecision decision;
  decision.robot_a = RobotId(request.robot_a());
  decision.robot_b = RobotId(request.robot_b());
  decision.session_a = SessionId(request.session_a());
  decision.session_b = SessionId(request.session_b());
  decision.note = request.note();
  const auto kind = FromMessage(kDecisions, request.decision(), std::optional<Decided>());
  if (!kind) {
    return absl::InvalidArgumentError("name the decision: ACCEPT, REJECT, SET or WITHDRAW");
  }
  decision.kind = *kind;
  if (decision.kind != ManualDecisionKind::kSet) return decision;
  if (!request.has_t_a_b()) {
    return absl::InvalidArgumentError("SET needs t_a_b, the pose of b's odom frame in a's");
  }
  const auto T_a_b = Checked(request.t_a_b(), "t_a_b");
  if (!T_a_b.ok()) return T_a_b.status();
  decision.T_a_b = *T_a_b;
  return decision;
}

}  // namespace isthmus::convert
