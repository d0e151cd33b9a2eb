// Robots for tests of the pipeline: a few scans of a simulated drive, and stores that fail.
#pragma once

#include <absl/status/status.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "client/simulation/simulator.h"
#include "core/codec/payload_builder.h"
#include "server/pipeline.h"
#include "storage/map_store.h"
#include "storage/memory_store.h"

namespace isthmus::server {

// A drive through the museum of one robot and the scans it would send.
class Drive {
 public:
  explicit Drive(int robots = 1, uint64_t seed = 3) {
    simulation::Options options;
    options.robots = robots;
    options.seed = seed;
    simulator_ = std::move(simulation::Simulator::Create(options).value());
  }

  // Scan `index` (from 0) as the upload of sequence index + 1.
  ScanUpload Upload(int index, int robot = 0) const {
    const Scan scan = simulator_->MakeScan(robot, index);
    return {scan.sequence, scan.end_stamp_ns, codec::MakePayload(scan)};
  }
  const simulation::Simulator& simulator() const { return *simulator_; }

 private:
  std::unique_ptr<simulation::Simulator> simulator_;
};

// Collects what a session is told. Thread safe.
class AckLog {
 public:
  AckSink Sink() {
    return [this](const ScanAck& ack) {
      std::lock_guard lock(mutex_);
      acks_.push_back(ack);
    };
  }
  std::vector<ScanAck> Take() {
    std::lock_guard lock(mutex_);
    return std::exchange(acks_, {});
  }

 private:
  std::mutex mutex_;
  std::vector<ScanAck> acks_;  // Guarded by mutex_.
};

// Passes everything on to another store, but for submaps while `full` is set: a disk without space.
class FullDisk : public storage::MapStore {
 public:
  FullDisk(std::unique_ptr<storage::MapStore> store, std::shared_ptr<std::atomic<bool>> full)
      : store_(std::move(store)), full_(std::move(full)) {}

  absl::Status Write(const storage::WriteBatch& batch) override {
    if (*full_ && !batch.submaps.empty()) return absl::ResourceExhaustedError("disk full");
    return store_->Write(batch);
  }
  absl::Status DeleteSession(const SessionId& id) override { return store_->DeleteSession(id); }
  absl::StatusOr<SessionRecord> GetSession(const SessionId& id) const override {
    return store_->GetSession(id);
  }
  absl::StatusOr<std::vector<SessionRecord>> ListSessions() const override {
    return store_->ListSessions();
  }
  absl::StatusOr<std::vector<TrajectoryEntry>> GetTrajectory(const SessionId& id) const override {
    return store_->GetTrajectory(id);
  }
  absl::StatusOr<storage::Checkpoint> GetCheckpoint(const SessionId& id) const override {
    return store_->GetCheckpoint(id);
  }
  absl::StatusOr<std::shared_ptr<const Submap>> GetSubmap(const SubmapId& id) const override {
    return store_->GetSubmap(id);
  }
  absl::StatusOr<uint64_t> StoredBytes(const SessionId& id) const override {
    return store_->StoredBytes(id);
  }
  absl::StatusOr<std::vector<SubmapInfo>> ListSubmaps(
      const std::optional<SessionId>& id) const override {
    return store_->ListSubmaps(id);
  }
  absl::StatusOr<std::vector<SubmapInfo>> FindSubmaps(const SessionId& id,
                                                      const Box& box) const override {
    return store_->FindSubmaps(id, box);
  }
  absl::StatusOr<std::vector<Match>> ListMatches() const override { return store_->ListMatches(); }
  absl::StatusOr<std::vector<Verdict>> ListVerdicts() const override {
    return store_->ListVerdicts();
  }
  absl::StatusOr<std::vector<LoopClosure>> ListLoops() const override {
    return store_->ListLoops();
  }
  absl::StatusOr<std::vector<Anchor>> ListAnchors() const override { return store_->ListAnchors(); }
  absl::StatusOr<MapRevision> LatestRevision() const override { return store_->LatestRevision(); }
  absl::StatusOr<std::vector<RevisionInfo>> ListRevisions(int limit) const override {
    return store_->ListRevisions(limit);
  }
  absl::StatusOr<std::vector<std::pair<int64_t, SubmapMove>>> ListMoves(int64_t from,
                                                                        int64_t to) const override {
    return store_->ListMoves(from, to);
  }
  absl::Status PutFeatures(const storage::FeatureBlob& blob) override {
    return store_->PutFeatures(blob);
  }
  absl::StatusOr<std::string> GetFeatures(const SubmapId& id,
                                          const std::string& kind) const override {
    return store_->GetFeatures(id, kind);
  }

 private:
  const std::unique_ptr<storage::MapStore> store_;
  const std::shared_ptr<std::atomic<bool>> full_;
};

// Composition at once, submaps of five scans.
inline PipelineOptions QuickOptions() {
  PipelineOptions options;
  options.composition_interval_s = 0;
  options.submap.cut_scans = 5;
  return options;
}

inline std::unique_ptr<Pipeline> OpenInMemory(const PipelineOptions& options = QuickOptions()) {
  return std::move(Pipeline::Open(options, storage::MakeMemoryStore()).value());
}

}  // namespace isthmus::server
