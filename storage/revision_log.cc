#include "storage/revision_log.h"

#include <absl/strings/str_cat.h>

#include <algorithm>

#include "storage/map_store.h"

namespace isthmus::storage {

RevisionInfo Describe(const MapRevision& revision, const std::vector<SubmapMove>& moves) {
  RevisionInfo info;
  info.revision = revision.revision;
  info.stamp_ns = revision.stamp_ns;
  info.cause = revision.cause;
  info.matches = revision.matches;
  info.loops = revision.loops;
  for (const SubmapMove& move : moves) {
    if (!move.before) {
      ++info.added;
    } else if (!move.after) {
      ++info.removed;
    } else {
      ++info.moved;
      if (move.frame_before != move.frame_after) continue;
      const double length_m = (move.after->translation() - move.before->translation()).norm();
      info.largest_move_m = std::max(info.largest_move_m, length_m);
    }
  }
  return info;
}

absl::Status CheckRange(int64_t from, int64_t to, int64_t oldest, int64_t latest) {
  if (to > latest) {
    return absl::NotFoundError(
        absl::StrCat("there is no revision ", to, " yet; the latest is ", latest));
  }
  if (from >= oldest) return absl::OkStatus();
  return absl::OutOfRangeError(absl::StrCat("what changed since revision ", from,
                                            " is not kept any more; ask from revision ", oldest,
                                            " on"));
}

void RevisionLog::Add(const MapRevision& revision, std::vector<SubmapMove> moves) {
  latest_ = revision;
  for (Placement& placement : latest_.placements) placement.submaps.clear();
  std::sort(latest_.placements.begin(), latest_.placements.end(),
            [](const Placement& a, const Placement& b) { return a.session < b.session; });
  std::sort(moves.begin(), moves.end(),
            [](const SubmapMove& a, const SubmapMove& b) { return a.submap < b.submap; });
  for (const SubmapMove& move : moves) {
    std::map<uint32_t, Pose>& submaps = placed_[move.submap.session];
    if (move.after) {
      submaps[move.submap.index] = *move.after;
    } else {
      submaps.erase(move.submap.index);
    }
    if (submaps.empty()) placed_.erase(move.submap.session);
  }
  move_count_ += static_cast<int64_t>(moves.size());
  const RevisionInfo info = Describe(revision, moves);
  entries_[revision.revision] = {info, std::move(moves)};
  Prune();
}

void RevisionLog::Prune() {
  while (entries_.size() > 1 && (entries_.size() > kRevisionsKept || move_count_ > kMovesKept)) {
    move_count_ -= static_cast<int64_t>(entries_.begin()->second.moves.size());
    entries_.erase(entries_.begin());
  }
}

MapRevision RevisionLog::Latest() const {
  MapRevision revision = latest_;
  for (Placement& placement : revision.placements) {
    const auto submaps = placed_.find(placement.session);
    if (submaps == placed_.end()) continue;
    for (const auto& [index, pose] : submaps->second) placement.submaps.push_back({index, pose});
  }
  return revision;
}

std::vector<RevisionInfo> RevisionLog::List(int limit) const {
  std::vector<RevisionInfo> infos;
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) {
    if (static_cast<int64_t>(infos.size()) >= limit) break;
    infos.push_back(entry->second.info);
  }
  return infos;
}

absl::StatusOr<std::vector<std::pair<int64_t, SubmapMove>>> RevisionLog::Moves(int64_t from,
                                                                               int64_t to) const {
  // The moves of the oldest entry are known, and so is the map before it.
  const int64_t oldest = entries_.empty() ? 0 : entries_.begin()->first - 1;
  if (auto status = CheckRange(from, to, oldest, latest()); !status.ok()) return status;
  std::vector<std::pair<int64_t, SubmapMove>> moves;
  for (auto entry = entries_.upper_bound(from); entry != entries_.end(); ++entry) {
    if (entry->first > to) break;
    for (const SubmapMove& move : entry->second.moves) moves.emplace_back(entry->first, move);
  }
  return moves;
}

}  // namespace isthmus::storage
