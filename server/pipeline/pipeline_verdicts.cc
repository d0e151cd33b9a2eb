// What a person says of matches.
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "core/note.h"
#include "server/match_graph/verdict.h"
#include "server/pipeline/pipeline_impl.h"

namespace isthmus::server {
namespace {

absl::Status CheckDecision(const MatchDecision& decision) {
  if (!decision.T_a_b.IsFinite()) {
    return absl::InvalidArgumentError("T_a_b has numbers that are not finite");
  }
  return CheckNote(decision.note);
}

}  // namespace

absl::StatusOr<SessionId> PipelineImpl::ResolveSession(const SessionId& session,
                                                       const RobotId& robot) {
  if (!session.empty()) {
    if (state_.Find(session) != nullptr) return session;
    return absl::NotFoundError(absl::StrCat("no session \"", session.value(), "\""));
  }
  const SessionEntry* newest = state_.Newest(robot);
  if (newest != nullptr) return newest->record.id;
  return absl::NotFoundError(absl::StrCat("no robot \"", robot.value(), "\""));
}

absl::StatusOr<Match> PipelineImpl::DecideMatch(const MatchDecision& decision) {
  if (absl::Status status = CheckDecision(decision); !status.ok()) return status;
  // Sessions must not go while the store is written.
  std::lock_guard changing(membership_mutex_);
  Verdict verdict;
  {
    std::lock_guard lock(state_.mutex);
    absl::StatusOr<SessionId> a = ResolveSession(decision.session_a, decision.robot_a);
    if (!a.ok()) return a.status();
    absl::StatusOr<SessionId> b = ResolveSession(decision.session_b, decision.robot_b);
    if (!b.ok()) return b.status();
    if (*a == *b) {
      return absl::InvalidArgumentError(
          absl::StrCat("a match is between two sessions; both are ", a->value()));
    }
    const auto computed = state_.matches.find(std::minmax(*a, *b));
    verdict.T_a_b = *a < *b ? decision.T_a_b : decision.T_a_b.Inverse();
    std::tie(verdict.a, verdict.b) = std::minmax(*a, *b);
    if (decision.ruling && *decision.ruling != Ruling::kSet) {
      const bool found = computed != state_.matches.end() && !computed->second.matcher.empty();
      if (!found && *decision.ruling == Ruling::kAccept) {
        return absl::FailedPreconditionError(absl::StrCat(
            "nothing was found between ", verdict.a.value(), " and ", verdict.b.value(),
            " that could be accepted: give the transform by hand (SET), or wait for more submaps"));
      }
      verdict.T_a_b = found ? computed->second.T_a_b : Pose();
    }
  }
  if (!decision.ruling) {
    absl::Status status = state_.PutWord({.withdrawn = {{verdict.a, verdict.b}}});
    if (!status.ok()) return status;
  } else {
    verdict.ruling = *decision.ruling;
    verdict.note = decision.note;
    verdict.given_ns = clock_.NowNs();
    if (absl::Status status = state_.PutWord({.verdicts = {verdict}}); !status.ok()) return status;
  }
  state_.WaitUntilPlaced();
  std::lock_guard lock(state_.mutex);
  const std::optional<Match> match = state_.EffectiveMatch({verdict.a, verdict.b});
  if (match) return *match;
  Match none;
  none.a = verdict.a;
  none.b = verdict.b;
  return none;
}

}  // namespace isthmus::server
