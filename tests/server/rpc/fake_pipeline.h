// A pipeline without odometry or matching: sessions in memory, scans acknowledged at once or when
// the test says so. For what the RPC layer makes of answers, errors and back-pressure.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/concurrency/mutex.h"
#include "server/map/map_view.h"
#include "server/map_feed.h"
#include "server/map_reader.h"
#include "server/pipeline.h"
#include "storage/memory_store.h"

namespace isthmus::rpc {

// Points given, filtered by box, sphere and robot.
class FakeMap : public ComposedMap {
 public:
  int64_t revision() const override { return 7; }
  const std::vector<RobotId>& robots() const override { return robots_; }
  uint32_t component_count() const override { return components_; }
  uint64_t point_count(uint32_t component) const override;
  Box bounds(uint32_t component) const override;
  std::optional<uint32_t> component_of(const SessionId& session) const override {
    const auto it = places_.find(session);
    return it == places_.end() ? std::nullopt : std::optional<uint32_t>(it->second);
  }
  absl::Status ready() const override { return ready_; }
  absl::Status Read(const Region& region, size_t chunk, const Emit& emit) const override;

  std::vector<RobotId> robots_;
  std::vector<MapPoint> points_;  // All of component 0.
  uint32_t components_ = 0;
  std::map<SessionId, uint32_t> places_;  // Component of each session.
  absl::Status ready_;
  absl::Status read_;  // Returned by Read at its end.
};

class FakePipeline : public server::Pipeline, public server::MapReader, public server::MapFeed {
 public:
  // It reads itself: of a view only the map, sessions and the revision count.
  const server::MapReader& reader() const override { return *this; }
  server::MapFeed& feed() override { return *this; }
  std::shared_ptr<const server::MapView> View() const override;
  MapInfo Describe(const server::MapView&) const override { return info; }
  ListAt<RobotAnchor> ListAnchors(const server::MapView& view) const override;
  absl::StatusOr<RobotTrajectory> GetTrajectory(const server::MapView& view, const RobotId& robot,
                                                TrajectoryFrame frame,
                                                uint32_t segment) const override;
  absl::StatusOr<std::vector<Track>> GetTracks(const server::MapView& view,
                                               const MapName& map) const override;
  // Reads `file` as a .bt.
  absl::StatusOr<FreeSpace> ReadFreeSpace(const server::MapView& view, const ExportRequest& wanted,
                                          uint64_t max_file_bytes,
                                          const std::function<bool()>& keep_on) const override;
  // Also as somebody who is not named.
  using server::Pipeline::CreateSession;
  using server::Pipeline::DeleteSession;
  using server::Pipeline::FinishSession;

  absl::StatusOr<SessionStatus> CreateSession(const SessionRequest& request,
                                              const Actor& by) override;
  absl::Status CheckTakesChanges() const override { return takes_changes; }
  absl::StatusOr<SessionStatus> GetSession(const SessionId& session) override;
  std::vector<SessionStatus> ListSessions() override;
  absl::StatusOr<SessionStatus> FinishSession(const SessionId& session, const Actor& by) override;
  absl::Status DeleteSession(const SessionId& session, const Actor& by) override;
  absl::Status SetAckSink(const SessionId& session, AckSink sink) override;
  absl::Status SubmitScan(const SessionId& session, ScanUpload scan) override {
    return OfferScan(session, &scan).status();
  }
  absl::StatusOr<bool> OfferScan(const SessionId& session, ScanUpload* scan) override;
  absl::StatusOr<SubmapInfo> AddSubmap(Submap submap) override;
  absl::StatusOr<std::unique_ptr<server::RobotLocaliser>> OpenLocaliser(
      const LocalisationRequest& request) override {
    asked_localisation = request;
    return absl::UnimplementedError("see localise_rpc_test.cc");
  }
  MapInfo GetMapInfo() override { return info; }
  ServerLoad GetLoad() override {
    MutexLock lock(&load_mutex);
    return load;
  }
  absl::StatusOr<ListAt<SubmapStatus>> ListSubmaps(const std::optional<RobotId>& robot) override;
  absl::StatusOr<RobotTrajectory> GetTrajectory(const RobotId& robot, TrajectoryFrame frame,
                                                uint32_t segment) override {
    return GetTrajectory(*View(), robot, frame, segment);
  }
  MatchGraph GetMatchGraph() override { return graph; }
  absl::StatusOr<DecidedMatch> DecideMatch(const MatchDecision& decision,
                                           const Actor& by) override {
    actors.push_back(by);
    decisions.push_back(decision);
    return decided;
  }
  absl::StatusOr<ListAt<Loop>> ListLoops(const std::optional<RobotId>& robot) override;
  absl::StatusOr<DecidedLoop> DecideLoop(const LoopDecision& decision, const Actor& by) override;
  absl::StatusOr<int64_t> PutAnchor(Anchor anchor, const Actor& by) override;
  absl::StatusOr<int64_t> RemoveAnchor(const SubmapId& submap, const Actor& by) override {
    actors.push_back(by);
    unanchored.push_back(submap);
    return anchored;
  }
  absl::StatusOr<std::vector<RevisionInfo>> ListRevisions(int limit) const override {
    asked_limit = limit;
    return revisions;
  }
  absl::StatusOr<RevisionDiff> DiffRevisions(int64_t from, int64_t to) const override {
    asked_diff = {from, to};
    return diff;
  }
  absl::StatusOr<ChangeList> FindChanges(const ChangeQuery& query,
                                         const std::function<bool()>& keep_on) const override {
    asked_changes = query;
    while (changes_wait && keep_on()) std::this_thread::yield();
    return changes_wait ? absl::CancelledError("stopped") : changes;
  }
  absl::StatusOr<int64_t> UndoRevision(int64_t revision, const std::string& note,
                                       const Actor& by) override;
  absl::StatusOr<std::string> ExportPoseGraph(const MapName& name) override {
    if (name.number() > 0) return absl::NotFoundError("no such component");
    return pose_graph;
  }
  absl::StatusOr<RobotTransform> GetTransform(const RobotId& a, const RobotId& b) const override;
  std::shared_ptr<const ComposedMap> GetMap() override { return map; }
  absl::Status SetDatum(std::optional<Datum> given, const Actor& by) override {
    actors.push_back(by);
    if (given && !CheckDatum(*given).ok()) return CheckDatum(*given);
    info.datum = given;
    return absl::OkStatus();
  }
  absl::Status ExportMap(const ExportRequest& request, const std::function<void(int64_t)>& begin,
                         const std::function<bool(const std::string&)>& sink) const override;
  absl::StatusOr<EventPage> ListEvents(const EventQuery& query) override;
  // Into the log at once; it tells who waits.
  void NoteEvent(Event event) override;
  void Note(const std::vector<Event>& events);
  uint64_t OnEvents(std::function<void()> wake) override;
  void ForgetEvents(uint64_t handle) override;
  // From a list of steps, each known by its revision in run 5.
  std::optional<MapStep> Since(const MapMark& known, uint32_t level) override;
  std::vector<RobotPlace> RobotPlaces() override;
  uint64_t OnChange(std::function<void()> wake) override;
  void Forget(uint64_t handle) override;
  // A new map; tells who waits.
  void ShowStep(MapStep step);
  void PutRobots(std::vector<RobotPlace> places);
  void WaitUntilIdle() override {}
  void StopTaking() override {}
  void Shutdown() override {}

  // The answers to readers. Set before use. `info.revision` is the lists' revision, too.
  MapInfo info;
  absl::Status takes_changes;  // Set before anybody asks.
  mutable Mutex load_mutex;
  ServerLoad load ABSL_GUARDED_BY(load_mutex);
  MatchGraph graph;
  std::shared_ptr<FakeMap> map = std::make_shared<FakeMap>();
  absl::StatusOr<RobotTrajectory> trajectory = absl::NotFoundError("no such robot");
  mutable uint32_t trajectory_segment = 0;  // As asked for last.
  absl::StatusOr<RobotTransform> transform = absl::NotFoundError("no such robot");
  absl::StatusOr<DecidedMatch> decided = absl::NotFoundError("no such robot");
  std::vector<MatchDecision> decisions;  // The decisions asked for.
  absl::StatusOr<std::vector<Loop>> loops = std::vector<Loop>();
  absl::StatusOr<DecidedLoop> decided_loop = absl::NotFoundError("no such loop closure");
  absl::StatusOr<int64_t> anchored = absl::NotFoundError("no such submap");
  absl::StatusOr<std::vector<RevisionInfo>> revisions = std::vector<RevisionInfo>();
  absl::StatusOr<RevisionDiff> diff = absl::NotFoundError("no such revision");
  absl::StatusOr<ChangeList> changes = absl::NotFoundError("no such component");
  bool changes_wait = false;  // Until the caller is gone.
  absl::StatusOr<int64_t> undo = absl::NotFoundError("no such revision");
  std::string pose_graph;  // Component 0's.
  // The place of a submap, by its name "alice-1/0"; others are not placed.
  std::map<std::string, Pose> placed;

  // The arguments of the last calls.
  std::optional<RobotId> asked_robot;
  std::vector<Actor> actors;  // One per change, in order.
  std::vector<LoopDecision> loop_decisions;
  std::vector<Anchor> anchors;
  std::vector<SubmapId> unanchored;
  mutable int asked_limit = -1;
  mutable std::pair<int64_t, int64_t> asked_diff;
  mutable ChangeQuery asked_changes;
  LocalisationRequest asked_localisation;
  std::vector<std::pair<int64_t, std::string>> undone;

  std::vector<std::string> file;               // Pieces ExportMap hands out.
  absl::Status export_status;                  // Returned after them.
  mutable std::vector<ExportRequest> exports;  // The exports asked for.

  // While held, scans wait in a queue of `capacity`; no more is taken when it is full.
  void Hold(size_t capacity);
  // Acknowledges what waits, and scans to come at once.
  void Release();
  size_t Waiting();
  // Waits until so many scans are in the queue.
  void WaitForQueued(size_t scans);
  // Sends an ack that only moves durable_sequence.
  void MakeDurable(const SessionId& session, uint64_t sequence);
  std::vector<Submap> submaps();
  // Scans taken, duplicates included.
  size_t submitted();

 private:
  struct Session {
    SessionStatus status;
    AckSink sink;
    uint64_t last_submitted = 0;
  };
  struct Queued {
    SessionId session;
    ScanUpload scan;
  };

  absl::StatusOr<Session*> Find(const SessionId& session) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  ScanAck Handle(Session& session, const ScanUpload& scan) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  mutable Mutex mutex_;
  CondVar changed_;
  std::map<SessionId, Session> sessions_ ABSL_GUARDED_BY(mutex_);
  std::deque<Queued> queue_ ABSL_GUARDED_BY(mutex_);
  std::vector<Submap> submaps_ ABSL_GUARDED_BY(mutex_);
  size_t submitted_ ABSL_GUARDED_BY(mutex_) = 0;
  size_t capacity_ ABSL_GUARDED_BY(mutex_) = 0;  // 0: not held.
  // The log lies in a store; it has all that a batch of events alone needs.
  const std::unique_ptr<storage::MapStore> log_ = storage::MakeMemoryStore();
  std::map<uint64_t, std::function<void()>> wakes_ ABSL_GUARDED_BY(mutex_);
  uint64_t next_wake_ ABSL_GUARDED_BY(mutex_) = 1;
  std::vector<MapStep> steps_ ABSL_GUARDED_BY(mutex_);
  std::vector<RobotPlace> places_ ABSL_GUARDED_BY(mutex_);
  std::map<uint64_t, std::function<void()>> map_wakes_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::rpc
