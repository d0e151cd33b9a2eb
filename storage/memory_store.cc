#include "storage/memory_store.h"

#include <absl/strings/str_cat.h>

#include <map>
#include <set>
#include <utility>

#include "core/concurrency/mutex.h"
#include "storage/batch_rules.h"
#include "storage/event_log.h"
#include "storage/map_records.h"
#include "storage/record_rules.h"
#include "storage/revision_log.h"

namespace isthmus::storage {
namespace {

// The data of one session beside its records.
struct SessionData {
  uint64_t order = 0;  // Order of insertion, because created_ns may repeat.
  std::map<uint64_t, TrajectoryEntry> trajectory;  // By sequence.
  std::optional<Checkpoint> checkpoint;
  std::optional<MatchingProgress> progress;
  std::map<uint32_t, std::shared_ptr<const Submap>> submaps;
  std::map<std::pair<uint32_t, std::string>, std::string> features;  // By submap and kind.
};

// In order of key.
template <typename Key, typename Value>
std::vector<Value> ValuesOf(const SharedMap<Key, Value>& map) {
  std::vector<Value> values;
  for (const auto& [key, value] : map) values.push_back(value);
  return values;
}

// Thread safe: one mutex, and nothing slow under it.
class MemoryStore : public MapStore {
 public:
  absl::Status Write(const WriteBatch& batch) override {
    // Bounds take a pass over the points: made before the lock is.
    const SubmapInfos infos = SummarizeSubmaps(batch);
    MutexLock lock(&mutex_);
    if (absl::Status status = Check(batch); !status.ok()) return status;
    Apply(batch, infos, &records_);
    for (const SessionRecord& record : batch.sessions) AddSession(record);
    PutCheckpoints(batch);
    for (const MatchingProgress& progress : batch.matching_progress) {
      sessions_.at(progress.session).progress = progress;
    }
    for (const auto& [session, entry] : batch.trajectory) {
      sessions_.at(session).trajectory.emplace(entry.sequence, entry);
    }
    for (const auto& submap : batch.submaps) {
      sessions_.at(submap->id.session).submaps[submap->id.index] = submap;
    }
    Retire(batch.retired);
    if (batch.revision) revisions_.Add(*batch.revision, batch.moves);
    events_.Add(batch.events);
    return absl::OkStatus();
  }

  using MapStore::DeleteSession;
  absl::Status DeleteSession(const SessionId& session, const std::vector<Event>& events) override {
    MutexLock lock(&mutex_);
    if (Find(session) == nullptr) return UnknownSession(session);
    if (absl::Status status = CheckEvents(events); !status.ok()) return status;
    events_.Add(events);
    for (const SessionId& id : RemoveSession(session, &records_)) sessions_.erase(id);
    return absl::OkStatus();
  }

  absl::StatusOr<SessionRecord> GetSession(const SessionId& session) const override {
    MutexLock lock(&mutex_);
    const SessionRecords* known = records_.sessions.Find(session);
    if (known == nullptr) return UnknownSession(session);
    return known->record;
  }

  absl::StatusOr<std::vector<SessionRecord>> ListSessions() const override {
    MutexLock lock(&mutex_);
    std::map<uint64_t, SessionRecord> by_order;
    for (const auto& [id, known] : records_.sessions) {
      by_order.emplace(sessions_.at(id).order, known.record);
    }
    std::vector<SessionRecord> records;
    records.reserve(by_order.size());
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

  absl::StatusOr<std::vector<MatchingProgress>> ListMatchingProgress() const override {
    MutexLock lock(&mutex_);
    std::vector<MatchingProgress> progress;
    for (const auto& [id, data] : sessions_) {
      if (data.progress) progress.push_back(*data.progress);
    }
    return progress;
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
    for (const auto& [id, known] : records_.sessions) {
      if (session && id != *session) continue;
      for (const auto& [index, info] : known.submaps) infos.push_back(info);
    }
    return infos;
  }

  absl::StatusOr<std::vector<Match>> ListMatches() const override {
    MutexLock lock(&mutex_);
    return ValuesOf(records_.matches);
  }

  absl::StatusOr<std::vector<ManualDecision>> ListManualDecisions() const override {
    MutexLock lock(&mutex_);
    return ValuesOf(records_.manual_decisions);
  }

  absl::StatusOr<std::vector<LoopClosure>> ListLoops() const override {
    MutexLock lock(&mutex_);
    return ValuesOf(records_.loops);
  }

  absl::StatusOr<std::vector<Anchor>> ListAnchors() const override {
    MutexLock lock(&mutex_);
    return ValuesOf(records_.anchors);
  }

  absl::StatusOr<std::optional<Datum>> GetDatum() const override {
    MutexLock lock(&mutex_);
    return records_.datum;
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

  absl::StatusOr<EventPage> ListEvents(const EventQuery& query) const override {
    MutexLock lock(&mutex_);
    return events_.List(query);
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

  void AddSession(const SessionRecord& record) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    const auto [item, is_new] = sessions_.try_emplace(record.id);
    if (is_new) item->second.order = next_order_++;
  }

  void PutCheckpoints(const WriteBatch& batch) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    for (const Checkpoint& checkpoint : batch.checkpoints) {
      sessions_.at(checkpoint.session).checkpoint = checkpoint;
    }
    for (const SessionRecord& record : batch.sessions) {
      if (record.state == SessionState::kFinished) sessions_.at(record.id).checkpoint.reset();
    }
  }

  void Retire(const std::vector<SubmapId>& retired) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    std::map<SessionId, std::set<uint32_t>> gone;
    for (const SubmapId& id : retired) {
      if (HasSubmap(id)) gone[id.session].insert(id.index);
    }
    for (const auto& of_session : gone) {
      const std::set<uint32_t>& indices = of_session.second;
      SessionData& data = sessions_.at(of_session.first);
      for (const uint32_t index : indices) data.submaps.erase(index);
      std::erase_if(data.features,
                    [&](const auto& item) { return indices.contains(item.first.first); });
      std::erase_if(data.trajectory,
                    [&](const auto& item) { return indices.contains(item.second.submap_index); });
    }
  }

  mutable Mutex mutex_;
  MapRecords records_ ABSL_GUARDED_BY(mutex_);
  std::map<SessionId, SessionData> sessions_ ABSL_GUARDED_BY(mutex_);  // The sessions of records_.
  RevisionLog revisions_ ABSL_GUARDED_BY(mutex_);
  EventLog events_ ABSL_GUARDED_BY(mutex_);
  uint64_t next_order_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace

std::unique_ptr<MapStore> MakeMemoryStore() { return std::make_unique<MemoryStore>(); }

}  // namespace isthmus::storage
