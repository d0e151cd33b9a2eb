#include "tests/storage/faulty_store.h"

#include <absl/strings/str_cat.h>

#include <thread>
#include <utility>

namespace isthmus::storage {
namespace {

class FaultyStore : public MapStore {
 public:
  FaultyStore(std::unique_ptr<MapStore> store, std::shared_ptr<Faults> faults)
      : store_(std::move(store)), faults_(std::move(faults)) {}

  absl::Status Write(const WriteBatch& batch) override {
    if (absl::Status status = faults_->BeforeWrite(); !status.ok()) return status;
    return store_->Write(batch);
  }
  using MapStore::DeleteSession;
  absl::Status DeleteSession(const SessionId& session, const std::vector<Event>& events) override {
    if (absl::Status status = faults_->BeforeWrite(); !status.ok()) return status;
    return store_->DeleteSession(session, events);
  }
  absl::StatusOr<EventPage> ListEvents(const EventQuery& query) const override {
    if (absl::Status status = faults_->BeforeRead(); !status.ok()) return status;
    return store_->ListEvents(query);
  }
  absl::Status PutFeatures(const FeatureBlob& blob) override {
    if (absl::Status status = faults_->BeforeWrite(); !status.ok()) return status;
    return store_->PutFeatures(blob);
  }
  absl::StatusOr<std::shared_ptr<const Submap>> GetSubmap(const SubmapId& submap) const override {
    if (auto status = faults_->BeforeReading(submap); !status.ok()) return status;
    const auto found = store_->GetSubmap(submap);
    if (!found.ok()) return found;
    return std::make_shared<const Submap>(**found);  // As one read from a disk.
  }
  absl::StatusOr<SessionRecord> GetSession(const SessionId& session) const override {
    if (absl::Status status = faults_->BeforeRead(); !status.ok()) return status;
    return store_->GetSession(session);
  }
  absl::StatusOr<std::vector<SessionRecord>> ListSessions() const override {
    if (absl::Status status = faults_->BeforeRead(); !status.ok()) return status;
    return store_->ListSessions();
  }
  absl::StatusOr<std::vector<TrajectoryEntry>> GetTrajectory(
      const SessionId& session) const override {
    if (absl::Status status = faults_->BeforeRead(); !status.ok()) return status;
    return store_->GetTrajectory(session);
  }
  absl::StatusOr<Checkpoint> GetCheckpoint(const SessionId& session) const override {
    if (absl::Status status = faults_->BeforeRead(); !status.ok()) return status;
    auto checkpoint = store_->GetCheckpoint(session);
    if (checkpoint.ok() && faults_->IsDamaged(session)) checkpoint->data.reset();
    return checkpoint;
  }
  absl::StatusOr<std::vector<MatchingProgress>> ListMatchingProgress() const override {
    if (absl::Status status = faults_->BeforeRead(); !status.ok()) return status;
    return store_->ListMatchingProgress();
  }
  absl::StatusOr<uint64_t> StoredBytes(const SessionId& session) const override {
    if (absl::Status status = faults_->BeforeRead(); !status.ok()) return status;
    return store_->StoredBytes(session);
  }
  absl::StatusOr<std::vector<SubmapInfo>> ListSubmaps(
      const std::optional<SessionId>& session) const override {
    if (absl::Status status = faults_->BeforeRead(); !status.ok()) return status;
    return store_->ListSubmaps(session);
  }
  absl::StatusOr<std::vector<Match>> ListMatches() const override {
    if (absl::Status status = faults_->BeforeRead(); !status.ok()) return status;
    return store_->ListMatches();
  }
  absl::StatusOr<std::vector<ManualDecision>> ListManualDecisions() const override {
    if (absl::Status status = faults_->BeforeRead(); !status.ok()) return status;
    return store_->ListManualDecisions();
  }
  absl::StatusOr<std::vector<LoopClosure>> ListLoops() const override {
    if (absl::Status status = faults_->BeforeRead(); !status.ok()) return status;
    return store_->ListLoops();
  }
  absl::StatusOr<std::vector<Anchor>> ListAnchors() const override {
    if (absl::Status status = faults_->BeforeRead(); !status.ok()) return status;
    return store_->ListAnchors();
  }
  absl::StatusOr<std::optional<Datum>> GetDatum() const override {
    if (absl::Status status = faults_->BeforeRead(); !status.ok()) return status;
    return store_->GetDatum();
  }
  absl::StatusOr<MapRevision> LatestRevision() const override {
    if (absl::Status status = faults_->BeforeRead(); !status.ok()) return status;
    return store_->LatestRevision();
  }
  absl::StatusOr<std::vector<RevisionInfo>> ListRevisions(int limit) const override {
    if (absl::Status status = faults_->BeforeRead(); !status.ok()) return status;
    return store_->ListRevisions(limit);
  }
  absl::StatusOr<std::vector<std::pair<int64_t, SubmapMove>>> ListMoves(int64_t from,
                                                                        int64_t to) const override {
    if (absl::Status status = faults_->BeforeRead(); !status.ok()) return status;
    return store_->ListMoves(from, to);
  }
  absl::StatusOr<std::string> GetFeatures(const SubmapId& submap,
                                          const std::string& kind) const override {
    if (absl::Status status = faults_->BeforeRead(); !status.ok()) return status;
    return store_->GetFeatures(submap, kind);
  }

 private:
  const std::unique_ptr<MapStore> store_;
  const std::shared_ptr<Faults> faults_;
};

}  // namespace

void Faults::SetDiskFull(bool is_full) {
  MutexLock lock(&mutex_);
  is_full_ = is_full;
}

void Faults::FailWrites(int count, const absl::Status& status) {
  MutexLock lock(&mutex_);
  fail_count_ = count;
  fail_status_ = status;
}

void Faults::SetFailureRate(double probability) {
  MutexLock lock(&mutex_);
  failure_rate_ = probability;
}

void Faults::Damage(const SubmapId& submap) {
  MutexLock lock(&mutex_);
  damaged_.insert(submap);
}

void Faults::Damage(const SessionId& session) {
  MutexLock lock(&mutex_);
  damaged_checkpoints_.insert(session);
}

bool Faults::IsDamaged(const SessionId& session) const {
  MutexLock lock(&mutex_);
  return damaged_checkpoints_.count(session) > 0;
}

void Faults::FailReads(const absl::Status& status) {
  MutexLock lock(&mutex_);
  read_status_ = status;
}

void Faults::SetSlowest(std::chrono::microseconds slowest) {
  MutexLock lock(&mutex_);
  slowest_ = slowest;
}

void Faults::Stall() {
  MutexLock lock(&mutex_);
  is_stalled_ = true;
}

void Faults::Resume() {
  MutexLock lock(&mutex_);
  is_stalled_ = false;
  resumed_.SignalAll();
}

int64_t Faults::writes() const {
  MutexLock lock(&mutex_);
  return writes_;
}

int64_t Faults::failed_writes() const {
  MutexLock lock(&mutex_);
  return failed_writes_;
}

absl::Status Faults::BeforeWrite() {
  std::chrono::duration<double, std::micro> delay(0);
  absl::Status status;
  {
    MutexLock lock(&mutex_);
    ++writes_;
    while (is_stalled_) resumed_.Wait(&mutex_);
    // Drawn in any case, so that the moments do not hang on what else is asked for.
    std::uniform_real_distribution<double> share(0, 1);
    delay = share(random_) * slowest_;
    if (share(random_) < failure_rate_) status = absl::UnavailableError("the disk did not answer");
    if (is_full_) status = absl::ResourceExhaustedError("the disk is full; free some space on it");
    if (fail_count_ > 0) {
      --fail_count_;
      status = fail_status_;
    }
    failed_writes_ += status.ok() ? 0 : 1;
  }
  if (delay.count() > 0) std::this_thread::sleep_for(delay);
  return status;
}

absl::Status Faults::BeforeRead() const {
  MutexLock lock(&mutex_);
  return read_status_;
}

absl::Status Faults::BeforeReading(const SubmapId& submap) const {
  MutexLock lock(&mutex_);
  if (damaged_.count(submap) == 0) return read_status_;
  return absl::DataLossError(
      absl::StrCat("submap ", ToString(submap), " is damaged: its checksum is wrong"));
}

std::unique_ptr<MapStore> MakeFaultyStore(std::unique_ptr<MapStore> store,
                                          std::shared_ptr<Faults> faults) {
  return std::make_unique<FaultyStore>(std::move(store), std::move(faults));
}

}  // namespace isthmus::storage
