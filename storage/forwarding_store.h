// A store that passes everything on to another: the base of stores that watch one, or spoil it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "storage/map_store.h"

namespace isthmus::storage {

class ForwardingStore : public MapStore {
 public:
  explicit ForwardingStore(std::unique_ptr<MapStore> store) : store_(std::move(store)) {}

  absl::Status Write(const WriteBatch& batch) override { return store_->Write(batch); }
  using MapStore::DeleteSession;
  absl::Status DeleteSession(const SessionId& session, const std::vector<Event>& events) override {
    return store_->DeleteSession(session, events);
  }
  absl::Status PutFeatures(const FeatureBlob& blob) override { return store_->PutFeatures(blob); }

  StoreSize SizeOnDisk() const override { return store_->SizeOnDisk(); }

  absl::StatusOr<SessionRecord> GetSession(const SessionId& session) const override {
    return store_->GetSession(session);
  }
  absl::StatusOr<std::vector<SessionRecord>> ListSessions() const override {
    return store_->ListSessions();
  }
  absl::StatusOr<uint64_t> StoredBytes(const SessionId& session) const override {
    return store_->StoredBytes(session);
  }
  absl::StatusOr<std::vector<TrajectoryEntry>> GetTrajectory(
      const SessionId& session) const override {
    return store_->GetTrajectory(session);
  }
  absl::StatusOr<Checkpoint> GetCheckpoint(const SessionId& session) const override {
    return store_->GetCheckpoint(session);
  }
  absl::StatusOr<std::vector<MatchingProgress>> ListMatchingProgress() const override {
    return store_->ListMatchingProgress();
  }
  absl::StatusOr<std::shared_ptr<const Submap>> GetSubmap(const SubmapId& submap) const override {
    return store_->GetSubmap(submap);
  }
  absl::StatusOr<std::vector<SubmapInfo>> ListSubmaps(
      const std::optional<SessionId>& session) const override {
    return store_->ListSubmaps(session);
  }
  absl::StatusOr<std::vector<Match>> ListMatches() const override { return store_->ListMatches(); }
  absl::StatusOr<std::vector<ManualDecision>> ListManualDecisions() const override {
    return store_->ListManualDecisions();
  }
  absl::StatusOr<std::vector<LoopClosure>> ListLoops() const override {
    return store_->ListLoops();
  }
  absl::StatusOr<std::vector<Anchor>> ListAnchors() const override { return store_->ListAnchors(); }
  absl::StatusOr<std::optional<Datum>> GetDatum() const override { return store_->GetDatum(); }
  absl::StatusOr<MapRevision> LatestRevision() const override { return store_->LatestRevision(); }
  absl::StatusOr<std::vector<RevisionInfo>> ListRevisions(int limit) const override {
    return store_->ListRevisions(limit);
  }
  absl::StatusOr<std::vector<std::pair<int64_t, SubmapMove>>> ListMoves(int64_t from,
                                                                        int64_t to) const override {
    return store_->ListMoves(from, to);
  }
  absl::StatusOr<EventPage> ListEvents(const EventQuery& query) const override {
    return store_->ListEvents(query);
  }
  absl::StatusOr<std::string> GetFeatures(const SubmapId& submap,
                                          const std::string& kind) const override {
    return store_->GetFeatures(submap, kind);
  }

  bool IsRemote() const override { return store_->IsRemote(); }
  JobQueue* jobs() override { return store_->jobs(); }

 private:
  const std::unique_ptr<MapStore> store_;
};

}  // namespace isthmus::storage
