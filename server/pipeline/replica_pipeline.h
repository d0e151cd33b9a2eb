// The pipeline of a server that only reads its map, and follows the server that has it.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/pipeline/reading_pipeline.h"
#include "server/threads/follower_thread.h"
#include "storage/map_follower.h"

namespace isthmus::server {

// Matches nothing, makes no revisions and takes nothing in: it composes the map as the other server
// has placed it. Every change is refused.
class ReplicaPipeline : public ReadingPipeline {
 public:
  ReplicaPipeline(const PipelineOptions& options, std::unique_ptr<storage::MapStore> store,
                  std::unique_ptr<storage::MapFollower> follower, const Clock& clock);
  ~ReplicaPipeline() override;

  // Reads all of the map and starts the threads. Call once.
  absl::Status Start();

  absl::Status CheckTakesChanges() const override;
  // One that is not there may be new: Unavailable in place of NotFound, so that its robot asks on.
  absl::StatusOr<SessionStatus> GetSession(const SessionId& session) override;
  MapInfo GetMapInfo() override;
  ServerLoad GetLoad() override;
  void NoteEvent(Event event) override;
  void WaitUntilIdle() override;
  void StopTaking() override {}
  void Shutdown() override;

  absl::StatusOr<SessionStatus> CreateSession(const SessionRequest&, const Actor&) override {
    return CheckTakesChanges();
  }
  absl::StatusOr<SessionStatus> FinishSession(const SessionId&, const Actor&) override {
    return CheckTakesChanges();
  }
  absl::Status DeleteSession(const SessionId&, const Actor&) override {
    return CheckTakesChanges();
  }
  absl::Status SetAckSink(const SessionId&, AckSink) override { return CheckTakesChanges(); }
  absl::Status SubmitScan(const SessionId&, ScanUpload) override { return CheckTakesChanges(); }
  absl::StatusOr<bool> OfferScan(const SessionId&, ScanUpload*) override {
    return CheckTakesChanges();
  }
  absl::StatusOr<SubmapInfo> AddSubmap(Submap) override { return CheckTakesChanges(); }
  absl::StatusOr<DecidedMatch> DecideMatch(const MatchDecision&, const Actor&) override {
    return CheckTakesChanges();
  }
  absl::StatusOr<DecidedLoop> DecideLoop(const LoopDecision&, const Actor&) override {
    return CheckTakesChanges();
  }
  absl::StatusOr<int64_t> PutAnchor(Anchor, const Actor&) override { return CheckTakesChanges(); }
  absl::StatusOr<int64_t> RemoveAnchor(const SubmapId&, const Actor&) override {
    return CheckTakesChanges();
  }
  absl::Status SetDatum(std::optional<Datum>, const Actor&) override { return CheckTakesChanges(); }
  absl::StatusOr<int64_t> UndoRevision(int64_t, const std::string&, const Actor&) override {
    return CheckTakesChanges();
  }

 private:
  // The places of robots that moved since the server started, at their newest scan that is stored.
  std::vector<RobotPlace> MappingPlaces() const override;

  FollowerThread follower_;
  // The scan that each session's trajectory ended with when the server started.
  std::map<SessionId, uint64_t> at_start_;
};

}  // namespace isthmus::server
