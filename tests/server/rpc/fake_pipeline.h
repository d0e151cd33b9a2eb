// A pipeline without odometry or matching: for what the RPC layer makes of answers, errors and
// back-pressure.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/concurrency/listeners.h"
#include "core/concurrency/mutex.h"
#include "server/map/map_view.h"
#include "server/pipeline.h"
#include "storage/memory_store.h"
#include "tests/server/rpc/fake_sessions.h"

namespace isthmus::rpc {

class FakeDecisions : public server::Decisions, public virtual FakeRecords {
 public:
  absl::StatusOr<DecidedMatch> DecideMatch(const MatchDecision& decision,
                                           const Actor& by) override {
    actors.push_back(by);
    match_decisions.push_back(decision);
    return decided;
  }
  absl::StatusOr<DecidedLoop> DecideLoop(const LoopDecision& decision, const Actor& by) override;
  absl::StatusOr<int64_t> PutAnchor(Anchor anchor, const Actor& by) override;
  absl::StatusOr<int64_t> RemoveAnchor(const SubmapId& submap, const Actor& by) override {
    actors.push_back(by);
    unanchored.push_back(submap);
    return anchored;
  }
  absl::Status SetDatum(std::optional<Datum> given, const Actor& by) override {
    actors.push_back(by);
    if (given && !CheckDatum(*given).ok()) return CheckDatum(*given);
    info.datum = given;
    return absl::OkStatus();
  }
  absl::StatusOr<int64_t> UndoRevision(int64_t revision, const std::string& note,
                                       const Actor& by) override;

  // The answers. Set before use.
  absl::StatusOr<DecidedMatch> decided = absl::NotFoundError("no such robot");
  absl::StatusOr<DecidedLoop> decided_loop = absl::NotFoundError("no such loop closure");
  absl::StatusOr<int64_t> anchored = absl::NotFoundError("no such submap");
  absl::StatusOr<int64_t> undo = absl::NotFoundError("no such revision");

  // The decisions asked for.
  std::vector<MatchDecision> match_decisions;
  std::vector<LoopDecision> loop_decisions;
  std::vector<SubmapId> unanchored;
  std::vector<std::pair<int64_t, std::string>> undone;
};

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

// Its answers are set by the test. Of a view only the map, sessions and the revision count.
class FakeReader : public server::MapReader, public virtual FakeRecords {
 public:
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
  absl::StatusOr<ListAt<SubmapStatus>> ListSubmaps(
      const std::optional<RobotId>& robot) const override;
  MatchGraph GetMatchGraph() const override { return graph; }
  absl::StatusOr<ListAt<Loop>> ListLoops(const std::optional<RobotId>& robot) const override;
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
  absl::StatusOr<RobotTransform> GetTransform(const RobotId& a, const RobotId& b) const override;
  absl::Status ExportMap(const ExportRequest& request, const std::function<void(int64_t)>& begin,
                         const std::function<bool(const std::string&)>& sink) const override;

  // The answers. Set before use.
  mutable Mutex load_mutex;
  ServerLoad load ABSL_GUARDED_BY(load_mutex);
  MatchGraph graph;
  std::shared_ptr<FakeMap> map = std::make_shared<FakeMap>();
  absl::StatusOr<RobotTrajectory> trajectory = absl::NotFoundError("no such robot");
  absl::StatusOr<RobotTransform> transform = absl::NotFoundError("no such robot");
  absl::StatusOr<std::vector<Loop>> loops = std::vector<Loop>();
  absl::StatusOr<std::vector<RevisionInfo>> revisions = std::vector<RevisionInfo>();
  absl::StatusOr<RevisionDiff> diff = absl::NotFoundError("no such revision");
  absl::StatusOr<ChangeList> changes = absl::NotFoundError("no such component");
  bool changes_wait = false;  // Until the caller is gone.
  // The place of a submap, by its name "alice-1/0"; others are not placed.
  std::map<std::string, Pose> placed;
  std::vector<std::string> file;  // Pieces ExportMap hands out.
  absl::Status export_status;     // Returned after them.

  // The arguments of the last calls.
  mutable uint32_t trajectory_segment = 0;
  mutable std::optional<RobotId> asked_robot;
  mutable int asked_limit = -1;
  mutable std::pair<int64_t, int64_t> asked_diff;
  mutable ChangeQuery asked_changes;
  mutable std::vector<ExportRequest> exports;  // The exports asked for.
};

class FakeEvents : public server::Events {
 public:
  absl::StatusOr<EventPage> List(const EventQuery& query) const override {
    return log_->ListEvents(query);
  }
  // Into the log at once; it tells who waits.
  void Note(Event event) override { NoteAll({std::move(event)}); }
  void NoteAll(const std::vector<Event>& events);
  uint64_t OnStored(std::function<void()> wake) override { return wakes_.Add(std::move(wake)); }
  void Forget(uint64_t handle) override { wakes_.Remove(handle); }

 private:
  // The log lies in a store; it has all that a batch of events alone needs.
  const std::unique_ptr<storage::MapStore> log_ = storage::MakeMemoryStore();
  Listeners wakes_;
};

class FakeFeed : public server::MapFeed {
 public:
  // From a list of steps, each known by its revision in run 5.
  std::optional<MapStep> Since(const MapMark& known, uint32_t level) override;
  uint64_t OnChange(std::function<void()> wake) override { return wakes_.Add(std::move(wake)); }
  void Forget(uint64_t handle) override { wakes_.Remove(handle); }
  // A new map; tells who waits.
  void ShowStep(MapStep step);

 private:
  Mutex mutex_;
  std::vector<MapStep> steps_ ABSL_GUARDED_BY(mutex_);
  Listeners wakes_;
};

// All of its parts in one, so that a test names what it sets and looks at without them.
class FakePipeline : public server::Pipeline,
                     public FakeSessions,
                     public FakeDecisions,
                     public FakeEvents,
                     public FakeReader,
                     public FakeFeed {
 public:
  absl::Status CheckTakesChanges() const override { return takes_changes; }
  server::Sessions& sessions() override { return *this; }
  server::Decisions& decisions() override { return *this; }
  server::Events& events() override { return *this; }
  const server::MapReader& reader() const override { return *this; }
  server::MapFeed& feed() override { return *this; }
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
  absl::StatusOr<std::string> ExportPoseGraph(const MapName& name) override {
    if (name.number() > 0) return absl::NotFoundError("no such component");
    return pose_graph;
  }
  std::vector<RobotPlace> RobotPlaces() override;
  void PutRobots(std::vector<RobotPlace> places);
  void WaitUntilIdle() override {}
  void StopTaking() override {}
  void Shutdown() override {}

  absl::Status takes_changes;              // Set before anybody asks.
  std::string pose_graph;                  // Component 0's.
  LocalisationRequest asked_localisation;  // As asked for last.

 private:
  Mutex places_mutex_;
  std::vector<RobotPlace> places_ ABSL_GUARDED_BY(places_mutex_);
};

}  // namespace isthmus::rpc
