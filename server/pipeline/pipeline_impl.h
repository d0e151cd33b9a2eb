// The pipeline that has the map: wires the parts together and hands calls on. See server/pipeline.h
// for the promises.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/concurrency/executor.h"
#include "server/pipeline/map_decisions.h"
#include "server/pipeline/reading_pipeline.h"
#include "server/threads/matching_thread.h"
#include "server/threads/store_retry_thread.h"

namespace isthmus::server {

class PipelineImpl : public ReadingPipeline {
 public:
  PipelineImpl(const PipelineOptions& options, std::unique_ptr<storage::MapStore> store,
               const Clock& clock);
  ~PipelineImpl() override;

  // Loads the store and starts the threads. Call once.
  absl::Status Start();

  absl::StatusOr<SessionStatus> CreateSession(const SessionRequest& request,
                                              const Actor& by) override {
    return sessions_.CreateSession(request, by);
  }
  absl::StatusOr<SessionStatus> FinishSession(const SessionId& session, const Actor& by) override {
    return sessions_.FinishSession(session, by);
  }
  absl::Status DeleteSession(const SessionId& session, const Actor& by) override;

  absl::Status SetAckSink(const SessionId& session, AckSink sink) override {
    return sessions_.SetAckSink(session, std::move(sink));
  }
  absl::Status SubmitScan(const SessionId& session, ScanUpload scan) override {
    return sessions_.AdmitScan(session, &scan, true).status();
  }
  absl::StatusOr<bool> OfferScan(const SessionId& session, ScanUpload* scan) override {
    return sessions_.AdmitScan(session, scan, false);
  }
  absl::StatusOr<SubmapInfo> AddSubmap(Submap submap) override {
    return sessions_.AddSubmap(std::move(submap));
  }

  ServerLoad GetLoad() override;
  absl::StatusOr<DecidedMatch> DecideMatch(const MatchDecision& decision,
                                           const Actor& by) override {
    return decisions_.DecideMatch(decision, by);
  }
  absl::StatusOr<DecidedLoop> DecideLoop(const LoopDecision& decision, const Actor& by) override {
    return decisions_.DecideLoop(decision, by);
  }
  absl::StatusOr<int64_t> PutAnchor(Anchor anchor, const Actor& by) override {
    return decisions_.PutAnchor(std::move(anchor), by);
  }
  absl::StatusOr<int64_t> RemoveAnchor(const SubmapId& submap, const Actor& by) override {
    return decisions_.RemoveAnchor(submap, by);
  }
  absl::Status SetDatum(std::optional<Datum> datum, const Actor& by) override {
    return decisions_.SetDatum(std::move(datum), by);
  }
  absl::StatusOr<int64_t> UndoRevision(int64_t revision, const std::string& note,
                                       const Actor& by) override {
    return decisions_.UndoRevision(revision, note, by);
  }
  void NoteEvent(Event event) override { parts_.events.Append(std::move(event)); }

  void WaitUntilIdle() override;
  void StopTaking() override;
  void Shutdown() override;

 private:
  bool IsSettled(uint64_t pending_scans, const MapView& view) const override;
  std::vector<RobotPlace> MappingPlaces() const override;

  MapDecisions decisions_;
  std::unique_ptr<MatchingThread> matching_;
  std::unique_ptr<Executor> storing_;  // Is given work by the executor's.
  std::unique_ptr<StoreRetryThread> store_retries_;
};

}  // namespace isthmus::server
