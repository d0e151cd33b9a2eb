#include "storage/memory_store.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "core/mutex.h"
#include "storage/batch_rules.h"
#include "storage/revision_log.h"

namespace isthmus::storage {
namespace {

// Everything of one session.
struct SessionData {
  SessionRecord record;
  uint64_t order = 0;                              // Of insertion, because created_ns may repeat.
  std::map<uint64_t, TrajectoryEntry> trajectory;  // By sequence.
  std::optional<Checkpoint> checkpoint;
  std::map<uint32_t, std::shared_ptr<const Submap>> submaps;
  std::map<uint32_t, SubmapInfo> infos;
  std::map<std::pair<uint32_t, std::string>, std::string> features;  // By submap and kind.
  std::map<uint32_t, Anchor> anchors;                                // By submap.
};

// Thread safe: one mutex, and nothing slow under it.
class MemoryStore : public MapStore {
 public:
  absl::Status Write(const WriteBatch& batch) override {
    // Bounds take a pass over the points: made before the lock is.
    std::vector<SubmapInfo> infos;
    for (const auto& submap : batch.submaps) infos.push_back(Summarize(*submap));
    MutexLock lock(&mutex_);
    if (absl::Status status = Check(batch); !status.ok()) return status;
    for (const SessionRecord& record : batch.sessions) PutSession(record);
    PutCheckpoints(batch);
    for (const auto& [session, entry] : batch.trajectory) {
      sessions_.at(session).trajectory.emplace(entry.sequence, entry);
    }
    for (size_t i = 0; i < infos.size(); ++i) {
      SessionData& data = sessions_.at(infos[i].id.session);
      data.submaps[infos[i].id.index] = batch.submaps[i];
      data.infos[infos[i].id.index] = infos[i];
    }
    for (const Match& match : batch.matches) {
      Match& kept = matches_[{match.a, match.b}] = match;
      kept.cycle_m = kept.cycle_deg = -1;
    }
    for (const Verdict& verdict : batch.verdicts) verdicts_[{verdict.a, verdict.b}] = verdict;
    for (const auto& pair : batch.withdrawn_verdicts) verdicts_.erase(pair);
    for (const LoopClosure& loop : batch.loops) loops_[loop.id] = loop;
    for (const Anchor& anchor : batch.anchors) {
      sessions_.at(anchor.submap.session).anchors[anchor.submap.index] = anchor;
    }
    for (const SubmapId& submap : batch.removed_anchors) RemoveAnchor(submap);
    Retire(batch.retired);
    if (batch.revision) revisions_.Add(*batch.revision, batch.moves);
    return absl::OkStatus();
  }

  absl::Status DeleteSession(const SessionId& session) override {
    MutexLock lock(&mutex_);
    if (Find(session) == nullptr) return UnknownSession(session);
    std::set<SessionId> gone;
    for (const auto& [id, data] : sessions_) {
      if (id == session || data.record.first_segment == session) gone.insert(id);
    }
    const auto of_session = [&](const auto& item) {
      return gone.contains(item.first.first) || gone.contains(item.first.second);
    };
    std::erase_if(sessions_, [&](const auto& item) { return gone.contains(item.first); });
    std::erase_if(matches_, of_session);
    std::erase_if(verdicts_, of_session);
    std::erase_if(loops_, [&](const auto& item) { return gone.contains(item.second.session); });
    return absl::OkStatus();
  }

  absl::StatusOr<SessionRecord> GetSession(const SessionId& session) const override {
    MutexLock lock(&mutex_);
    const SessionData* data = Find(session);
    if (data == nullptr) return UnknownSession(session);
    return data->record;
  }

  absl::StatusOr<std::vector<SessionRecord>> ListSessions() const override {
    MutexLock lock(&mutex_);
    std::map<uint64_t, SessionRecord> by_order;
    for (const auto& [id, data] : sessions_) by_order.emplace(data.order, data.record);
    std::vector<SessionRecord> records;
    for (auto& [order, record] : by_order) records.push_back(std::move(record));
    return records;
  }

  absl::StatusOr<uint64_t> StoredBytes(const SessionId& session) const override {
    MutexLock lock(&mutex_);
    const SessionData* data = Find(session);
    if (data == nullptr) return UnknownSession(session);
    uint64_t bytes = 0;
    for (const auto& [index, submap] : data->submaps) {
      bytes += submap->points.size() * sizeof(SubmapPoint);
    }
    for (const auto& [key, blob] : data->features) bytes += blob.size();
    return bytes;
  }

  absl::StatusOr<std::vector<TrajectoryEntry>> GetTrajectory(
      const SessionId& session) const override {
    MutexLock lock(&mutex_);
    const SessionData* data = Find(session);
    if (data == nullptr) return UnknownSession(session);
    std::vector<TrajectoryEntry> entries;
    for (const auto& [sequence, entry] : data->trajectory) entries.push_back(entry);
    return entries;
  }

  absl::StatusOr<Checkpoint> GetCheckpoint(const SessionId& session) const override {
    MutexLock lock(&mutex_);
    const SessionData* data = Find(session);
    if (data == nullptr) return UnknownSession(session);
    if (!data->checkpoint) return NoCheckpoint(session);
    return *data->checkpoint;
  }

  absl::StatusOr<std::shared_ptr<const Submap>> GetSubmap(const SubmapId& id) const override {
    MutexLock lock(&mutex_);
    if (!HasSubmap(id)) return UnknownSubmap(id);
    return sessions_.at(id.session).submaps.at(id.index);
  }

  absl::StatusOr<std::vector<SubmapInfo>> ListSubmaps(
      const std::optional<SessionId>& session) const override {
    MutexLock lock(&mutex_);
    if (session && Find(*session) == nullptr) return UnknownSession(*session);
    std::vector<SubmapInfo> infos;
    for (const auto& [id, data] : sessions_) {
      if (session && id != *session) continue;
      for (const auto& [index, info] : data.infos) infos.push_back(info);
    }
    return infos;
  }

  absl::StatusOr<std::vector<SubmapInfo>> FindSubmaps(const SessionId& session,
                                                      const Box& box_odom) const override {
    MutexLock lock(&mutex_);
    const SessionData* data = Find(session);
    if (data == nullptr) return UnknownSession(session);
    std::vector<SubmapInfo> infos;
    for (const auto& [index, info] : data->infos) {
      const Box bounds = Transform(info.T_odom_submap, info.bounds);
      if (!bounds.empty() && bounds.Intersects(box_odom)) infos.push_back(info);
    }
    return infos;
  }

  absl::StatusOr<std::vector<Match>> ListMatches() const override {
    MutexLock lock(&mutex_);
    std::vector<Match> matches;
    for (const auto& [pair, match] : matches_) matches.push_back(match);
    return matches;
  }

  absl::StatusOr<std::vector<Verdict>> ListVerdicts() const override {
    MutexLock lock(&mutex_);
    std::vector<Verdict> verdicts;
    for (const auto& [pair, verdict] : verdicts_) verdicts.push_back(verdict);
    return verdicts;
  }

  absl::StatusOr<std::vector<LoopClosure>> ListLoops() const override {
    MutexLock lock(&mutex_);
    std::vector<LoopClosure> loops;
    for (const auto& [id, loop] : loops_) loops.push_back(loop);
    return loops;
  }

  absl::StatusOr<std::vector<Anchor>> ListAnchors() const override {
    MutexLock lock(&mutex_);
    std::vector<Anchor> anchors;
    for (const auto& [id, data] : sessions_) {
      for (const auto& [index, anchor] : data.anchors) anchors.push_back(anchor);
    }
    return anchors;
  }

  absl::StatusOr<MapRevision> LatestRevision() const override {
    MutexLock lock(&mutex_);
    return revisions_.Latest();
  }

  absl::StatusOr<std::vector<RevisionInfo>> ListRevisions(int limit) const override {
    MutexLock lock(&mutex_);
    return revisions_.List(limit);
  }

  absl::StatusOr<std::vector<std::pair<int64_t, SubmapMove>>> ListMoves(int64_t from,
                                                                        int64_t to) const override {
    MutexLock lock(&mutex_);
    return revisions_.Moves(from, to);
  }

  absl::Status PutFeatures(const FeatureBlob& blob) override {
    MutexLock lock(&mutex_);
    if (!HasSubmap(blob.submap)) return UnknownSubmap(blob.submap);
    sessions_.at(blob.submap.session).features[{blob.submap.index, blob.kind}] = blob.data;
    return absl::OkStatus();
  }

  absl::StatusOr<std::string> GetFeatures(const SubmapId& submap,
                                          const std::string& kind) const override {
    MutexLock lock(&mutex_);
    if (!HasSubmap(submap)) return UnknownSubmap(submap);
    const auto& features = sessions_.at(submap.session).features;
    const auto found = features.find({submap.index, kind});
    if (found == features.end()) return NoFeatures(submap, kind);
    return found->second;
  }

 private:
  const SessionData* Find(const SessionId& session) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    const auto found = sessions_.find(session);
    return found == sessions_.end() ? nullptr : &found->second;
  }

  bool HasSubmap(const SubmapId& id) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    const SessionData* data = Find(id.session);
    return data != nullptr && data->submaps.count(id.index) > 0;
  }

  absl::Status Check(const WriteBatch& batch) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return CheckBatch(
        batch, {.has_session = [this](const SessionId& id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(
                                   mutex_) { return Find(id) != nullptr; },
                .has_submap = [this](const SubmapId& id)
                                  ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return HasSubmap(id); },
                .latest_revision = revisions_.latest()});
  }

  void PutSession(const SessionRecord& record) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    const auto [item, is_new] = sessions_.try_emplace(record.id);
    if (is_new) item->second.order = next_order_++;
    item->second.record = record;
  }

  void PutCheckpoints(const WriteBatch& batch) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    for (const Checkpoint& checkpoint : batch.checkpoints) {
      sessions_.at(checkpoint.session).checkpoint = checkpoint;
    }
    for (const SessionRecord& record : batch.sessions) {
      if (record.state == SessionState::kFinished) sessions_.at(record.id).checkpoint.reset();
    }
  }

  void RemoveAnchor(const SubmapId& submap) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    const auto found = sessions_.find(submap.session);
    if (found != sessions_.end()) found->second.anchors.erase(submap.index);
  }

  static void RetireOf(SessionData& data, const std::set<uint32_t>& indices) {
    const auto by_index = [&](const auto& item) { return indices.count(item.first) > 0; };
    std::erase_if(data.submaps, by_index);
    std::erase_if(data.infos, by_index);
    std::erase_if(data.anchors, by_index);
    std::erase_if(data.features,
                  [&](const auto& item) { return indices.count(item.first.first) > 0; });
    std::erase_if(data.trajectory,
                  [&](const auto& item) { return indices.count(item.second.submap_index) > 0; });
  }

  void Retire(const std::vector<SubmapId>& retired) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    std::map<SessionId, std::set<uint32_t>> gone;
    for (const SubmapId& id : retired) {
      if (HasSubmap(id)) gone[id.session].insert(id.index);
    }
    for (const auto& [session, indices] : gone) RetireOf(sessions_.at(session), indices);
    std::erase_if(loops_, [&](const auto& item) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      const LoopClosure& loop = item.second;
      return gone.count(loop.session) > 0 &&
             std::none_of(loop.edges.begin(), loop.edges.end(),
                          [&](const SubmapEdge& edge) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
                            return HasSubmap({loop.session, edge.submap_a}) &&
                                   HasSubmap({loop.session, edge.submap_b});
                          });
    });
  }

  mutable Mutex mutex_;
  std::map<SessionId, SessionData> sessions_ ABSL_GUARDED_BY(mutex_);
  std::map<std::pair<SessionId, SessionId>, Match> matches_ ABSL_GUARDED_BY(mutex_);
  std::map<std::pair<SessionId, SessionId>, Verdict> verdicts_ ABSL_GUARDED_BY(mutex_);
  std::map<uint64_t, LoopClosure> loops_ ABSL_GUARDED_BY(mutex_);  // By id.
  RevisionLog revisions_ ABSL_GUARDED_BY(mutex_);
  uint64_t next_order_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace

std::unique_ptr<MapStore> MakeMemoryStore() { return std::make_unique<MemoryStore>(); }

}  // namespace isthmus::storage
