// The pipeline behind its interface: wires the parts together and hands on what is asked. See
// server/pipeline.h for what is promised.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/concurrency/executor.h"
#include "server/localisation/placed_maps.h"
#include "server/pipeline.h"
#include "server/pipeline/map_decisions.h"
#include "server/pipeline/map_reader.h"
#include "server/pipeline/map_watch.h"
#include "server/pipeline/pipeline_parts.h"
#include "server/pipeline/sessions.h"
#include "server/threads/composition_thread.h"
#include "server/threads/matching_thread.h"
#include "server/threads/placement_thread.h"
#include "server/threads/retention_thread.h"
#include "server/threads/store_retry_thread.h"

namespace isthmus::server {

class PipelineImpl : public Pipeline {
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
  absl::StatusOr<SessionStatus> GetSession(const SessionId& session) override {
    return sessions_.GetSession(session);
  }
  std::vector<SessionStatus> ListSessions() override { return sessions_.ListSessions(); }
  absl::StatusOr<SessionStatus> FinishSession(const SessionId& session, const Actor& by) override {
    return sessions_.FinishSession(session, by);
  }
  absl::Status DeleteSession(const SessionId& session, const Actor& by) override;

  absl::Status SetAckSink(const SessionId& session, AckSink sink) override {
    return sessions_.SetAckSink(session, std::move(sink));
  }
  absl::Status SubmitScan(const SessionId& session, ScanUpload scan) override {
    return sessions_.SubmitScan(session, std::move(scan));
  }
  bool HasRoom(const SessionId& session, size_t bytes) override {
    return sessions_.HasRoom(session, bytes);
  }
  absl::StatusOr<SubmapInfo> AddSubmap(Submap submap) override {
    return sessions_.AddSubmap(std::move(submap));
  }

  absl::StatusOr<std::unique_ptr<RobotLocaliser>> OpenLocaliser(
      const LocalisationRequest& request) override;

  MapInfo GetMapInfo() override;
  ServerLoad GetLoad() override;
  absl::StatusOr<ListAt<SubmapStatus>> ListSubmaps(const std::optional<RobotId>& robot) override {
    return reader_.ListSubmaps(robot);
  }
  using Pipeline::GetTrajectory;
  absl::StatusOr<RobotTrajectory> GetTrajectory(const RobotId& robot, TrajectoryFrame frame,
                                                uint32_t segment) override;
  MatchGraph GetMatchGraph() override { return reader_.GetMatchGraph(); }
  absl::StatusOr<DecidedMatch> DecideMatch(const MatchDecision& decision,
                                           const Actor& by) override {
    return decisions_.DecideMatch(decision, by);
  }
  absl::StatusOr<ListAt<Loop>> ListLoops(const std::optional<RobotId>& robot) override {
    return reader_.ListLoops(robot);
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
  ListAt<RobotAnchor> ListAnchors() override { return reader_.ListAnchors(); }
  absl::StatusOr<std::vector<RevisionInfo>> ListRevisions(int limit) override {
    return reader_.ListRevisions(limit);
  }
  absl::StatusOr<RevisionDiff> DiffRevisions(int64_t from, int64_t to) override {
    return reader_.DiffRevisions(from, to);
  }
  absl::StatusOr<ChangeList> FindChanges(const ChangeQuery& query,
                                         const std::function<bool()>& keep_on) override {
    return reader_.FindChanges(query, keep_on);
  }
  absl::StatusOr<int64_t> UndoRevision(int64_t revision, const std::string& note,
                                       const Actor& by) override {
    return decisions_.UndoRevision(revision, note, by);
  }
  absl::StatusOr<std::string> ExportPoseGraph(uint32_t component) override {
    return placement_->WriteG2o(component);
  }
  absl::StatusOr<RobotTransform> GetTransform(const RobotId& a, const RobotId& b) override {
    return reader_.GetTransform(a, b);
  }
  std::shared_ptr<const ComposedMap> GetMap() override { return reader_.GetMap(); }
  absl::Status ExportMap(const ExportRequest& request, const std::function<void(int64_t)>& begin,
                         const std::function<bool(const std::string&)>& sink) override {
    return reader_.ExportMap(request, begin, sink);
  }

  absl::StatusOr<EventPage> ListEvents(const EventQuery& query) override {
    return parts_.store->ListEvents(query);
  }
  void NoteEvent(Event event) override { parts_.events.Append(std::move(event)); }
  uint64_t OnEvents(std::function<void()> wake) override {
    return parts_.events.OnStored(std::move(wake));
  }
  void ForgetEvents(uint64_t handle) override { parts_.events.Forget(handle); }

  std::optional<MapStep> MapSince(const MapMark& known, uint32_t level) override {
    return map_watch_.Since(known, level);
  }
  std::vector<RobotPlace> RobotPlaces() override;
  uint64_t OnMap(std::function<void()> wake) override {
    return map_watch_.OnChange(std::move(wake));
  }
  void ForgetMap(uint64_t handle) override { map_watch_.Forget(handle); }

  void WaitUntilIdle() override;
  void StopTaking() override;
  void Shutdown() override;

 private:
  RetentionThread::Hooks RetentionHooks();
  void AddSessions(const MapView& view, ServerLoad* load) const;
  DiskLoad GetDiskLoad(const MapView& view, uint64_t spilled_bytes) const;
  // True if nothing is under way, or waits, that the view does not show yet.
  bool IsSettled(uint64_t pending_scans, const MapView& view) const;

  PipelineParts parts_;
  Sessions sessions_;
  const MapReader reader_;
  MapDecisions decisions_;
  MapWatch map_watch_;
  std::unique_ptr<RetentionThread> retention_;  // Is told by whatever is below.
  // Destroyed in reverse: the executors first, so that no worker's task outlives the threads.
  std::unique_ptr<MatchingThread> matching_;
  std::unique_ptr<CompositionThread> composition_;
  std::unique_ptr<PlacementThread> placement_;
  std::unique_ptr<Executor> storing_;  // Is given work by the executor's.
  std::unique_ptr<Executor> executor_;
  std::unique_ptr<localisation::PlacedMaps> placed_maps_;  // Uses the executor.
  std::unique_ptr<StoreRetryThread> store_retries_;
};

}  // namespace isthmus::server
