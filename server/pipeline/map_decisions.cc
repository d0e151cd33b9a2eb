#include "server/pipeline/map_decisions.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/concurrency/mutex.h"
#include "server/pipeline/view_reader.h"

namespace isthmus::server {
namespace {

absl::Status CheckAnchor(const Anchor& anchor) {
  const double sigmas[] = {anchor.sigma_xy_m, anchor.sigma_z_m, anchor.sigma_deg};
  const bool usable = std::all_of(std::begin(sigmas), std::end(sigmas), [](double sigma) {
    return std::isfinite(sigma) && (sigma == 0 || sigma >= kMinAnchorSigma);
  });
  if (!usable || *std::max_element(std::begin(sigmas), std::end(sigmas)) == 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("an anchor's standard deviations are 0, which says that this part of the pose "
                     "is not known, or at least ",
                     kMinAnchorSigma, ", and one of them is not 0"));
  }
  if (!anchor.T_map_submap.IsFinite()) {
    return absl::InvalidArgumentError("the anchor's pose has numbers that are not finite");
  }
  if (anchor.T_map_submap.translation().cwiseAbs().maxCoeff() > kMaxAnchorM) {
    return absl::InvalidArgumentError(
        absl::StrCat("the anchor is more than ", kMaxAnchorM / 1000,
                     " km from the origin: give coordinates relative to a point of the site"));
  }
  return absl::OkStatus();
}

}  // namespace

int64_t MapDecisions::RevisionOncePlaced() const {
  parts_.map.WaitUntilPlaced();
  return parts_.map.view()->revision->revision;
}

absl::StatusOr<DecidedLoop> MapDecisions::DecideLoop(const LoopDecision& decision,
                                                     const Actor& by) {
  if (absl::Status status = parts_.check_takes_changes(); !status.ok()) return status;
  LoopClosure loop;
  {
    MutexLock changing(&parts_.membership);
    const std::shared_ptr<const LoopClosure> known = parts_.map.view()->loops.Get(decision.id);
    if (known == nullptr) {
      return absl::NotFoundError(absl::StrCat("no loop closure ", decision.id,
                                              ": list those there are; retired submaps' are gone"));
    }
    loop = *known;
    loop.rejected = decision.rejected;
    loop.note = decision.note;
    if (absl::Status status = parts_.map.PutDecisions({.loops = {loop}, .by = by}); !status.ok()) {
      return status;
    }
  }
  parts_.map.WaitUntilPlaced();
  const MapWriter::View view = parts_.map.view();
  return DecidedLoop{view->revision->revision, ViewReader::Describe(loop, *view)};
}

absl::StatusOr<int64_t> MapDecisions::PutAnchor(Anchor anchor, const Actor& by) {
  if (absl::Status status = parts_.check_takes_changes(); !status.ok()) return status;
  if (absl::Status status = CheckAnchor(anchor); !status.ok()) return status;
  {
    MutexLock changing(&parts_.membership);
    const MapWriter::View view = parts_.map.view();
    const SessionView* session = view->Find(anchor.submap.session);
    if (session == nullptr || !session->submaps.contains(anchor.submap.index)) {
      return absl::NotFoundError(
          absl::StrCat("no submap ", ToString(anchor.submap), ": list those there are"));
    }
    anchor.given_ns = parts_.clock.NowNs();
    if (absl::Status status = parts_.map.PutAnchor(anchor, by); !status.ok()) return status;
  }
  return RevisionOncePlaced();
}

absl::StatusOr<int64_t> MapDecisions::RemoveAnchor(const SubmapId& submap, const Actor& by) {
  if (absl::Status status = parts_.check_takes_changes(); !status.ok()) return status;
  {
    MutexLock changing(&parts_.membership);
    if (!parts_.map.view()->anchors.contains(submap)) {
      return absl::NotFoundError(absl::StrCat("submap ", ToString(submap), " has no anchor"));
    }
    if (absl::Status status = parts_.map.RemoveAnchor(submap, by); !status.ok()) return status;
  }
  return RevisionOncePlaced();
}

absl::Status MapDecisions::SetDatum(std::optional<Datum> datum, const Actor& by) {
  if (absl::Status status = parts_.check_takes_changes(); !status.ok()) return status;
  if (datum) {
    if (absl::Status status = CheckDatum(*datum); !status.ok()) return status;
    datum->given_ns = parts_.clock.NowNs();
  }
  return parts_.map.SetDatum(datum, by);
}

ManualEdit MapDecisions::RejectCauses(const RevisionInfo& revision, const std::string& note) const {
  ManualEdit decisions;
  const MapWriter::View view = parts_.map.view();
  for (const SessionPair& pair : revision.matches) {
    const Match* match = view->EffectiveMatch(pair);
    if (match == nullptr || match->state != MatchState::kAccepted) continue;
    const ManualDecision* given = view->manual_decisions.Find(pair);
    if (given != nullptr && given->kind == ManualDecisionKind::kSet) {
      decisions.withdrawn.push_back(pair);
      continue;
    }
    decisions.manual_decisions.push_back({pair.first, pair.second, ManualDecisionKind::kReject,
                                          match->T_a_b, note, parts_.clock.NowNs()});
  }
  for (const uint64_t id : revision.loops) {
    const LoopClosure* known = view->loops.Find(id);
    if (known == nullptr || known->rejected) continue;
    LoopClosure& loop = decisions.loops.emplace_back(*known);
    loop.rejected = true;
    loop.note = note;
  }
  return decisions;
}

absl::StatusOr<int64_t> MapDecisions::UndoRevision(int64_t revision, const std::string& note,
                                                   const Actor& by) {
  if (absl::Status status = parts_.check_takes_changes(); !status.ok()) return status;
  const absl::StatusOr<std::vector<RevisionInfo>> revisions =
      parts_.store->ListRevisions(std::numeric_limits<int>::max());
  if (!revisions.ok()) return revisions.status();
  const auto info = std::find_if(revisions->begin(), revisions->end(),
                                 [&](const auto& r) { return r.revision == revision; });
  if (info == revisions->end()) {
    return absl::NotFoundError(
        absl::StrCat("revision ", revision, " is not kept: list those that are"));
  }
  {
    // Sessions must not go while the store is written.
    MutexLock changing(&parts_.membership);
    ManualEdit rejected = RejectCauses(*info, note);
    if (rejected.manual_decisions.empty() && rejected.withdrawn.empty() && rejected.loops.empty()) {
      return absl::FailedPreconditionError(
          absl::StrCat("revision ", revision, " (", info->cause,
                       ") came of no match or loop closure that still counts: nothing to reject"));
    }
    rejected.by = by;
    rejected.undone = revision;
    rejected.note = note;
    if (absl::Status status = parts_.map.PutDecisions(rejected); !status.ok()) return status;
  }
  return RevisionOncePlaced();
}

}  // namespace isthmus::server
