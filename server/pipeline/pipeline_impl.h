// The pipeline behind its interface: sessions in, map out. See server/pipeline.h for what is
// promised.
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/executor.h"
#include "server/pipeline.h"
#include "server/pipeline/compositor.h"
#include "server/pipeline/estimator.h"
#include "server/pipeline/map_state.h"
#include "server/pipeline/placement_loop.h"
#include "server/pipeline/retention_loop.h"
#include "server/pipeline/scan_keeper.h"
#include "server/pipeline/store_health.h"

namespace isthmus::server {

class PipelineImpl : public Pipeline {
 public:
  PipelineImpl(const PipelineOptions& options, std::unique_ptr<storage::MapStore> store,
               const Clock& clock);
  ~PipelineImpl() override;

  // Loads the store and starts the loops. Call once.
  absl::Status Start();

  absl::StatusOr<SessionStatus> CreateSession(const SessionRequest& request) override;
  absl::StatusOr<SessionStatus> GetSession(const SessionId& session) override;
  std::vector<SessionStatus> ListSessions() override;
  absl::StatusOr<SessionStatus> FinishSession(const SessionId& session) override;
  absl::Status DeleteSession(const SessionId& session) override;

  absl::Status SetAckSink(const SessionId& session, AckSink sink) override;
  absl::Status SubmitScan(const SessionId& session, ScanUpload scan) override;
  absl::StatusOr<SubmapInfo> AddSubmap(Submap submap) override;

  MapInfo GetMapInfo() override;
  absl::StatusOr<std::vector<SubmapStatus>> ListSubmaps(
      const std::optional<RobotId>& robot) override;
  using Pipeline::GetTrajectory;
  absl::StatusOr<RobotTrajectory> GetTrajectory(const RobotId& robot, TrajectoryFrame frame,
                                                uint32_t segment) override;
  MatchGraphView GetMatchGraph() override;
  absl::StatusOr<Match> DecideMatch(const MatchDecision& decision) override;
  absl::StatusOr<std::vector<LoopStatus>> ListLoops(const std::optional<RobotId>& robot) override;
  absl::StatusOr<LoopStatus> DecideLoop(const LoopDecision& decision) override;
  absl::StatusOr<int64_t> PutAnchor(Anchor anchor) override;
  absl::StatusOr<int64_t> RemoveAnchor(const SubmapId& submap) override;
  std::vector<Anchor> ListAnchors() override;
  absl::StatusOr<std::vector<RevisionInfo>> ListRevisions(int limit) override;
  absl::StatusOr<RevisionDiff> DiffRevisions(int64_t from, int64_t to) override;
  absl::StatusOr<int64_t> UndoRevision(int64_t revision, const std::string& note) override;
  absl::StatusOr<std::string> ExportPoseGraph(uint32_t component) override;
  absl::StatusOr<RobotTransform> GetTransform(const RobotId& a, const RobotId& b) override;
  std::shared_ptr<const ComposedMap> GetMap() override;
  absl::Status ExportMap(ExportFormat format, const Region& region, double octomap_resolution_m,
                         const std::function<bool(const std::string&)>& sink) override;

  void WaitUntilIdle() override;
  void Shutdown() override;

 private:
  // The session that was opened for the same robot and request id.
  std::optional<SessionStatus> FindRequested(const SessionRecord& record);
  absl::StatusOr<std::shared_ptr<ingest::SessionWorker>> MakeWorker(
      const SessionRecord& record, const ingest::ResumePoint& resume);
  // That goes on where the session, its first segment, is stored to be.
  absl::StatusOr<std::shared_ptr<ingest::SessionWorker>> ResumeWorker(const SessionEntry& entry);
  absl::StatusOr<ingest::StoredSegment> ReadSegment(const SessionEntry& entry);
  // Absent where there is none.
  std::optional<ingest::Checkpoint> ReadCheckpoint(const SessionId& session);
  RetentionLoop::Hooks RetentionHooks();
  // `why`, for the revision's cause, is empty where someone asked for it.
  absl::Status Delete(const SessionId& session, const std::string& why);
  // NotFound, or FailedPrecondition for a later segment of a session.
  absl::StatusOr<SessionEntry*> FindOpened(const SessionId& session);
  // The worker of an active session that takes scans.
  absl::StatusOr<std::shared_ptr<ingest::SessionWorker>> FindWorker(const SessionId& session);
  // The state's mutex is held for these.
  absl::StatusOr<SessionId> ResolveSession(const SessionId& session, const RobotId& robot);
  SessionStatus StatusOf(const SessionEntry& entry) const;
  // What is told of a session as a whole, in its first segment.
  void FillStreamStatus(const SessionEntry& entry, SessionStatus* status) const;
  LoopStatus StatusOf(const LoopClosure& loop) const;
  bool IsSettled() const;
  // Thread: while the store fails, tries again what waits for it.
  void RunStoreRetries();
  bool RetryStoring();  // Whether nothing waits any more.
  // These take the state's mutex.
  int64_t RevisionOncePlaced();
  void NoteDamage(const SubmapId& submap, const std::string& problem);

  const PipelineOptions options_;
  const Clock& clock_;
  StoreHealth health_;
  const std::unique_ptr<storage::MapStore> store_;  // Tells health_.
  SubmapCache submaps_;
  MapState state_;
  std::unique_ptr<ScanKeeper> scans_;
  // Held while a session comes, finishes or goes and while an uploaded submap is taken in: what is
  // written to the store then is what the state says. Locked before the state's mutex.
  std::mutex membership_mutex_;
  // The numbers given to the robots' sessions. A deleted session's number is not given again: the
  // slow loop may still be at work on its map. Guarded by membership_mutex_.
  std::map<RobotId, int> last_numbers_;
  std::atomic<bool> shut_down_ = false;
  std::unique_ptr<RetentionLoop> retention_;  // Is told by whatever is below.
  // Destroyed in reverse: the executor first, so that no worker's task outlives the loops.
  std::unique_ptr<Estimator> estimator_;
  std::unique_ptr<Compositor> compositor_;
  std::unique_ptr<PlacementLoop> placement_;
  std::unique_ptr<Executor> executor_;
  std::thread store_retries_;
};

}  // namespace isthmus::server
