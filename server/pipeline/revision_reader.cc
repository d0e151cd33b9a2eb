// The history of the map.
#include <absl/strings/str_cat.h>

#include <limits>
#include <map>
#include <utility>

#include "core/geometry/near.h"
#include "server/pipeline/view_reader.h"

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

absl::StatusOr<std::vector<RevisionInfo>> ViewReader::ListRevisions(int limit) const {
  return store_->ListRevisions(limit);
}

absl::StatusOr<RevisionDiff> ViewReader::DiffRevisions(int64_t from, int64_t to) const {
  RevisionDiff diff;
  diff.from = from;
  diff.to = to == 0 ? map_->view()->revision->revision : to;
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

}  // namespace isthmus::server
