// People's decisions about matches.
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "core/concurrency/mutex.h"
#include "server/pipeline/map_decisions.h"
#include "server/pipeline/view_reader.h"

namespace isthmus::server {
namespace {

absl::Status CheckDecision(const MatchDecision& decision) {
  if (!decision.T_a_b.IsFinite()) {
    return absl::InvalidArgumentError("T_a_b has numbers that are not finite");
  }
  return absl::OkStatus();
}

absl::StatusOr<SessionId> ResolveSession(const MapView& view, const SessionId& session,
                                         const RobotId& robot) {
  if (!session.empty()) {
    if (view.Find(session) != nullptr) return session;
    return absl::NotFoundError(absl::StrCat("no session \"", session.value(), "\""));
  }
  const SessionView* newest = view.Newest(robot);
  if (newest != nullptr) return newest->record.id;
  return absl::NotFoundError(absl::StrCat("no robot \"", robot.value(), "\""));
}

// The pair that is meant and the decision on it; without kind and time where it is to be
// withdrawn.
absl::StatusOr<ManualDecision> MakeManualDecision(const MatchDecision& decision,
                                                  const MapView& view) {
  absl::StatusOr<SessionId> a = ResolveSession(view, decision.session_a, decision.robot_a);
  if (!a.ok()) return a.status();
  absl::StatusOr<SessionId> b = ResolveSession(view, decision.session_b, decision.robot_b);
  if (!b.ok()) return b.status();
  if (*a == *b) {
    return absl::InvalidArgumentError(
        absl::StrCat("a match is between two sessions; both are ", a->value()));
  }
  ManualDecision manual_decision;
  manual_decision.T_a_b = *a < *b ? decision.T_a_b : decision.T_a_b.Inverse();
  std::tie(manual_decision.a, manual_decision.b) = std::minmax(*a, *b);
  manual_decision.note = decision.note;
  if (!decision.kind) return manual_decision;
  manual_decision.kind = *decision.kind;
  if (manual_decision.kind == ManualDecisionKind::kSet) return manual_decision;
  const Match* computed = view.matches.Find({manual_decision.a, manual_decision.b});
  const bool found = computed != nullptr && computed->matcher != GuessSource::kNone;
  if (!found && manual_decision.kind == ManualDecisionKind::kAccept) {
    return absl::FailedPreconditionError(absl::StrCat(
        "nothing was found between ", manual_decision.a.value(), " and ", manual_decision.b.value(),
        " that could be accepted: give the transform by hand (SET), or wait for more submaps"));
  }
  manual_decision.T_a_b = found ? computed->T_a_b : Pose();
  return manual_decision;
}

}  // namespace

absl::StatusOr<DecidedMatch> MapDecisions::DecideMatch(const MatchDecision& decision,
                                                       const Actor& by) {
  if (absl::Status status = parts_.check_takes_changes(); !status.ok()) return status;
  if (absl::Status status = CheckDecision(decision); !status.ok()) return status;
  SessionPair pair;
  {
    MutexLock changing(&parts_.membership);
    absl::StatusOr<ManualDecision> manual_decision =
        MakeManualDecision(decision, *parts_.map.view());
    if (!manual_decision.ok()) return manual_decision.status();
    pair = {manual_decision->a, manual_decision->b};
    manual_decision->given_ns = parts_.clock.NowNs();
    ManualEdit edit;
    edit.by = by;
    edit.note = decision.note;
    if (decision.kind) {
      edit.manual_decisions = {*manual_decision};
    } else {
      edit.withdrawn = {pair};
    }
    if (absl::Status status = parts_.map.PutDecisions(edit); !status.ok()) return status;
  }
  parts_.map.WaitUntilPlaced();
  const MapWriter::View view = parts_.map.view();
  const int64_t revision = view->revision->revision;
  if (const Match* match = view->EffectiveMatch(pair)) {
    return DecidedMatch{revision, ViewReader::Describe(*match, *view)};
  }
  Match none;
  std::tie(none.a, none.b) = pair;
  return DecidedMatch{revision, ViewReader::Describe(none, *view)};
}

}  // namespace isthmus::server
