// How the map came to be what it is, and how to go back.
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "core/geometry/near.h"
#include "core/note.h"
#include "server/pipeline/pipeline_impl.h"

namespace isthmus::server {
namespace {

// It ended where it began.
bool CameBack(const SubmapMove& move) {
  if (!move.before || !move.after) return !move.before && !move.after;
  if (move.frame_before != move.frame_after) return false;
  return AreNear(*move.before, *move.after, 1e-9, 1e-9);
}

// From where each submap was before the first move to where it was after the last.
std::vector<SubmapMove> Join(const std::vector<std::pair<int64_t, SubmapMove>>& moves) {
  std::map<SubmapId, SubmapMove> joined;
  for (const auto& [revision, move] : moves) {
    const auto [it, is_first] = joined.try_emplace(move.submap, move);
    if (is_first) continue;
    it->second.after = move.after;
    it->second.frame_after = move.frame_after;
  }
  std::vector<SubmapMove> list;
  for (auto& [id, move] : joined) {
    if (!CameBack(move)) list.push_back(std::move(move));
  }
  return list;
}

}  // namespace

absl::StatusOr<std::vector<RevisionInfo>> PipelineImpl::ListRevisions(int limit) {
  return store_->ListRevisions(limit);
}

absl::StatusOr<RevisionDiff> PipelineImpl::DiffRevisions(int64_t from, int64_t to) {
  RevisionDiff diff;
  diff.from = from;
  {
    std::lock_guard lock(state_.mutex);
    diff.to = to == 0 ? state_.revision.revision : to;
  }
  if (diff.from > diff.to) {
    return absl::InvalidArgumentError(
        absl::StrCat("revision ", diff.from, " does not come before ", diff.to));
  }
  const auto moves = store_->ListMoves(diff.from, diff.to);
  if (!moves.ok()) return moves.status();
  diff.moves = Join(*moves);
  absl::StatusOr<std::vector<RevisionInfo>> revisions =
      store_->ListRevisions(std::numeric_limits<int>::max());
  if (!revisions.ok()) return revisions.status();
  for (RevisionInfo& info : *revisions) {
    if (info.revision > diff.from && info.revision <= diff.to) {
      diff.revisions.push_back(std::move(info));
    }
  }
  return diff;
}

absl::StatusOr<int64_t> PipelineImpl::UndoRevision(int64_t revision, const std::string& note) {
  if (absl::Status status = CheckNote(note); !status.ok()) return status;
  const absl::StatusOr<std::vector<RevisionInfo>> revisions =
      store_->ListRevisions(std::numeric_limits<int>::max());
  if (!revisions.ok()) return revisions.status();
  const auto info = std::find_if(revisions->begin(), revisions->end(),
                                 [&](const auto& r) { return r.revision == revision; });
  if (info == revisions->end()) {
    return absl::NotFoundError(
        absl::StrCat("revision ", revision, " is not kept: list those that are"));
  }
  // Sessions must not go while the store is written.
  std::lock_guard changing(membership_mutex_);
  Word word;
  {
    std::lock_guard lock(state_.mutex);
    for (const SessionPair& pair : info->matches) {
      const std::optional<Match> match = state_.EffectiveMatch(pair);
      if (!match || match->state != MatchState::kAccepted) continue;
      const auto said = state_.verdicts.find(pair);
      if (said != state_.verdicts.end() && said->second.ruling == Ruling::kSet) {
        word.withdrawn.push_back(pair);
        continue;
      }
      word.verdicts.push_back(
          {pair.first, pair.second, Ruling::kReject, match->T_a_b, note, clock_.NowNs()});
    }
    for (const uint64_t id : info->loops) {
      const auto it = state_.loops.find(id);
      if (it == state_.loops.end() || it->second.rejected) continue;
      LoopClosure& loop = word.loops.emplace_back(it->second);
      loop.rejected = true;
      loop.note = note;
    }
  }
  if (word.verdicts.empty() && word.withdrawn.empty() && word.loops.empty()) {
    return absl::FailedPreconditionError(
        absl::StrCat("revision ", revision, " (", info->cause,
                     ") came of no match or loop closure that still counts: nothing to reject"));
  }
  if (absl::Status status = state_.PutWord(word); !status.ok()) return status;
  return RevisionOncePlaced();
}

}  // namespace isthmus::server
