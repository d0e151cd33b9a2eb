#include "server/match_graph/effective_match.h"

#include <string>

namespace isthmus::match_graph {
namespace {

std::string Detail(const ManualDecision& manual_decision, const std::optional<Match>& computed) {
  std::string detail = manual_decision.kind == ManualDecisionKind::kSet      ? "given by hand"
                       : manual_decision.kind == ManualDecisionKind::kAccept ? "accepted by hand"
                                                                             : "rejected by hand";
  if (!manual_decision.note.empty()) detail += ": " + manual_decision.note;
  if (computed) {
    detail += std::string(" (computed: ") + ToString(computed->state) + " " +
              ToString(computed->reason) +
              (computed->detail.empty() ? "" : ", " + computed->detail) + ")";
  }
  return detail;
}

}  // namespace

Match EffectiveMatch(const ManualDecision& manual_decision, const std::optional<Match>& computed) {
  Match match = computed.value_or(Match());
  match.a = manual_decision.a;
  match.b = manual_decision.b;
  match.reason = MatchReason::kByHand;
  match.detail = Detail(manual_decision, computed);
  if (manual_decision.kind == ManualDecisionKind::kReject) {
    match.state = MatchState::kRejected;
    match.confidence = 0;
    if (!computed) match.T_a_b = manual_decision.T_a_b;
    return match;
  }
  match.state = MatchState::kAccepted;
  match.confidence = 1;
  match.T_a_b = manual_decision.T_a_b;
  if (manual_decision.kind == ManualDecisionKind::kSet) match.matcher = GuessSource::kByHand;
  return match;
}

}  // namespace isthmus::match_graph
