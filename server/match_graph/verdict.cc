#include "server/match_graph/verdict.h"

#include <string>

namespace isthmus::match_graph {
namespace {

std::string Detail(const Verdict& verdict, const std::optional<Match>& computed) {
  std::string detail = verdict.ruling == Ruling::kSet      ? "given by hand"
                       : verdict.ruling == Ruling::kAccept ? "accepted by hand"
                                                           : "rejected by hand";
  if (!verdict.note.empty()) detail += ": " + verdict.note;
  if (computed) {
    detail += std::string(" (computed: ") + ToString(computed->state) + " " +
              ToString(computed->reason) +
              (computed->detail.empty() ? "" : ", " + computed->detail) + ")";
  }
  return detail;
}

}  // namespace

Match Apply(const Verdict& verdict, const std::optional<Match>& computed) {
  Match match = computed.value_or(Match());
  match.a = verdict.a;
  match.b = verdict.b;
  match.reason = MatchReason::kByHand;
  match.detail = Detail(verdict, computed);
  if (verdict.ruling == Ruling::kReject) {
    match.state = MatchState::kRejected;
    match.confidence = 0;
    if (!computed) match.T_a_b = verdict.T_a_b;
    return match;
  }
  match.state = MatchState::kAccepted;
  match.confidence = 1;
  match.T_a_b = verdict.T_a_b;
  if (verdict.ruling == Ruling::kSet) match.matcher = GuessSource::kByHand;
  return match;
}

}  // namespace isthmus::match_graph
