// What changes the map: stored first, then shown.
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <set>
#include <utility>

#include "server/pipeline/map_state.h"

namespace isthmus::server {
namespace {

// Of what came between two revisions so many are named; the rest is counted by their moves.
constexpr size_t kMaxCauses = 4;

std::string NameOf(const SessionId& a, const SessionId& b) {
  return absl::StrCat("match ", a.value(), " ~ ", b.value());
}

bool NamesOneOf(const SessionPair& pair, const std::set<SessionId>& sessions) {
  return sessions.contains(pair.first) || sessions.contains(pair.second);
}

}  // namespace

void MapState::Changed(const std::string& cause) {
  ++graph_version;
  if (changes.causes.size() < kMaxCauses) {
    changes.causes.push_back(cause);
  } else if (changes.causes.size() == kMaxCauses) {
    changes.causes.emplace_back("and more");
  }
  changed.notify_all();
}

std::vector<SessionRecord> MapState::NewSegments(const SessionId& session,
                                                 const ingest::Stretch& stretch) {
  std::set<uint32_t> numbers;
  if (stretch.submap != nullptr) numbers.insert(stretch.segment);
  if (stretch.checkpoint) numbers.insert(stretch.checkpoint->segment);
  std::vector<SessionRecord> records;
  std::lock_guard lock(mutex);
  const SessionEntry* opened = Find(session);
  for (const uint32_t number : numbers) {
    const SessionId id = SegmentId(session, number);
    if (opened == nullptr || Find(id) != nullptr) continue;
    SessionRecord& record = records.emplace_back(opened->record);
    record.id = id;
    record.segment = number;
    record.first_segment = session;
    record.request_id.clear();
    record.created_ns = clock_->NowNs();
  }
  return records;
}

absl::Status MapState::AddStretch(const SessionId& session, const ingest::Stretch& stretch) {
  const SessionId segment = SegmentId(session, stretch.segment);
  storage::WriteBatch batch;
  batch.sessions = NewSegments(session, stretch);
  if (stretch.submap != nullptr) batch.submaps.push_back(stretch.submap);
  if (const auto& checkpoint = stretch.checkpoint) {
    batch.checkpoints.push_back(
        {session, checkpoint->sequence, checkpoint->durable_sequence, checkpoint->state});
  }
  for (const TrajectoryEntry& entry : stretch.trajectory) {
    batch.trajectory.emplace_back(segment, entry);
  }
  // Outside the lock: the disk may take its time, and one session writes one stretch at a time.
  if (absl::Status status = store_->Write(batch); !status.ok()) return status;
  std::lock_guard lock(mutex);
  if (Find(session) == nullptr) {
    return absl::NotFoundError(absl::StrCat("session ", session.value(), " was deleted"));
  }
  for (const SessionRecord& record : batch.sessions) sessions[record.id].record = record;
  SessionEntry* entry = Find(segment);
  if (stretch.submap == nullptr) return absl::OkStatus();
  cache_->Put(stretch.submap);
  entry->submaps.push_back(std::make_shared<const SubmapInfo>(Summarize(*stretch.submap)));
  entry->points += stretch.submap->points.size();
  for (const TrajectoryEntry& pose : stretch.trajectory) entry->AddPose(pose);
  if (entry->submaps.size() == 1) RefreshMatches();
  Changed(absl::StrCat("submap ", ToString(stretch.submap->id)));
  return absl::OkStatus();
}

absl::Status MapState::PutMatch(const Match& match) {
  {
    std::lock_guard lock(mutex);
    if (Find(match.a) == nullptr || Find(match.b) == nullptr) return absl::OkStatus();
  }
  storage::WriteBatch batch;
  batch.matches.push_back(match);
  if (absl::Status status = store_->Write(batch); !status.ok()) return status;
  std::lock_guard lock(mutex);
  if (Find(match.a) == nullptr || Find(match.b) == nullptr) return absl::OkStatus();
  matches[{match.a, match.b}] = match;
  changes.matches.emplace_back(match.a, match.b);
  RefreshMatches();
  Changed(absl::StrCat(NameOf(match.a, match.b), " ", ToString(match.state)));
  return absl::OkStatus();
}

absl::Status MapState::PutWord(const Word& word) {
  storage::WriteBatch batch;
  batch.verdicts = word.verdicts;
  batch.withdrawn_verdicts = word.withdrawn;
  batch.loops = word.loops;
  if (absl::Status status = store_->Write(batch); !status.ok()) return status;
  std::lock_guard lock(mutex);
  for (const Verdict& verdict : word.verdicts) {
    verdicts[{verdict.a, verdict.b}] = verdict;
    changes.matches.emplace_back(verdict.a, verdict.b);
    Changed(absl::StrCat(NameOf(verdict.a, verdict.b), " by hand: ", ToString(verdict.ruling)));
  }
  for (const SessionPair& pair : word.withdrawn) {
    verdicts.erase(pair);
    changes.matches.push_back(pair);
    Changed(absl::StrCat(NameOf(pair.first, pair.second), ": word by hand withdrawn"));
  }
  for (const LoopClosure& loop : word.loops) {
    loops[loop.id] = loop;
    changes.loops.push_back(loop.id);
    Changed(absl::StrCat("loop ", loop.id, " by hand: ", loop.rejected ? "REJECT" : "RESTORE"));
  }
  RefreshMatches();
  return absl::OkStatus();
}

absl::Status MapState::AddLoops(std::vector<LoopClosure> found) {
  if (found.empty()) return absl::OkStatus();
  storage::WriteBatch batch;
  {
    std::lock_guard lock(mutex);
    for (LoopClosure& loop : found) {
      if (Find(loop.session) == nullptr) continue;
      loop.id = next_loop_++;
      loop.computed_ns = clock_->NowNs();
      batch.loops.push_back(std::move(loop));
    }
  }
  if (batch.loops.empty()) return absl::OkStatus();
  if (absl::Status status = store_->Write(batch); !status.ok()) return status;
  std::lock_guard lock(mutex);
  for (const LoopClosure& loop : batch.loops) {
    if (Find(loop.session) == nullptr) continue;
    loops[loop.id] = loop;
    changes.loops.push_back(loop.id);
    Changed(absl::StrCat("loop ", loop.id, ": ", ToString(SubmapId{loop.session, loop.submap_b}),
                         " on ", loop.submap_a));
  }
  return absl::OkStatus();
}

absl::Status MapState::PutAnchor(const Anchor& anchor) {
  storage::WriteBatch batch;
  batch.anchors.push_back(anchor);
  if (absl::Status status = store_->Write(batch); !status.ok()) return status;
  std::lock_guard lock(mutex);
  anchors[anchor.submap] = anchor;
  Changed(absl::StrCat("anchor of ", ToString(anchor.submap)));
  return absl::OkStatus();
}

absl::Status MapState::RemoveAnchor(const SubmapId& submap) {
  storage::WriteBatch batch;
  batch.removed_anchors.push_back(submap);
  if (absl::Status status = store_->Write(batch); !status.ok()) return status;
  std::lock_guard lock(mutex);
  anchors.erase(submap);
  Changed(absl::StrCat("anchor of ", ToString(submap), " removed"));
  return absl::OkStatus();
}

absl::Status MapState::Retire(const std::vector<SubmapId>& submaps) {
  if (submaps.empty()) return absl::OkStatus();
  storage::WriteBatch batch;
  batch.retired = submaps;
  if (absl::Status status = store_->Write(batch); !status.ok()) return status;
  std::lock_guard lock(mutex);
  const std::set<SubmapId> gone(submaps.begin(), submaps.end());
  for (const SubmapId& id : gone) {
    anchors.erase(id);
    SessionEntry* entry = Find(id.session);
    const std::shared_ptr<const SubmapInfo> submap = entry ? entry->FindSubmap(id.index) : nullptr;
    if (submap == nullptr) continue;
    entry->points -= submap->point_count;
    entry->way_m.erase(id.index);
    std::erase(entry->submaps, submap);
    cache_->Forget(id);
    damaged.erase(id);
    ++retired;
  }
  std::erase_if(loops, [&](const auto& item) {
    const LoopClosure& loop = item.second;
    return std::all_of(loop.edges.begin(), loop.edges.end(), [&](const SubmapEdge& edge) {
      const SessionEntry* entry = Find(loop.session);
      return entry == nullptr || !entry->FindSubmap(edge.submap_a) ||
             !entry->FindSubmap(edge.submap_b);
    });
  });
  Changed(absl::StrCat(gone.size(), " submaps retired, ", ToString(*gone.begin()), " first"));
  return absl::OkStatus();
}

absl::Status MapState::RemoveSession(const SessionId& session, const std::string& why) {
  if (absl::Status status = store_->DeleteSession(session); !status.ok()) return status;
  std::lock_guard lock(mutex);
  ++removals;
  std::set<SessionId> gone;
  for (const SessionEntry* entry : SegmentsOf(session)) {
    for (const auto& submap : entry->submaps) cache_->Forget(submap->id);
    gone.insert(entry->record.id);
  }
  std::erase_if(sessions, [&](const auto& item) { return gone.contains(item.first); });
  std::erase_if(damaged, [&](const auto& item) { return gone.contains(item.first.session); });
  std::erase_if(matches, [&](const auto& item) { return NamesOneOf(item.first, gone); });
  std::erase_if(verdicts, [&](const auto& item) { return NamesOneOf(item.first, gone); });
  std::erase_if(loops, [&](const auto& item) { return gone.contains(item.second.session); });
  std::erase_if(anchors, [&](const auto& item) { return gone.contains(item.first.session); });
  RefreshMatches();
  Changed(absl::StrCat("session ", session.value(), " deleted", why.empty() ? "" : ": ", why));
  return absl::OkStatus();
}

}  // namespace isthmus::server
