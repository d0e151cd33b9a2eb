// A pipeline without odometry or matching: sessions in memory, scans acknowledged at once or when
// the test says so. For what the RPC layer makes of answers, errors and back-pressure.
#pragma once

#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/pipeline.h"

namespace isthmus::rpc {

// Points given, filtered by box, sphere and robot.
class FakeMap : public ComposedMap {
 public:
  int64_t revision() const override { return 7; }
  const std::vector<RobotId>& robots() const override { return robots_; }
  uint32_t component_count() const override { return components_; }
  uint64_t point_count(uint32_t component) const override;
  Box bounds(uint32_t component) const override;
  void Read(const Region& region, size_t chunk, const Emit& emit) const override;

  std::vector<RobotId> robots_;
  std::vector<MapPoint> points_;  // All of component 0.
  uint32_t components_ = 0;
};

class FakePipeline : public server::Pipeline {
 public:
  absl::StatusOr<server::SessionStatus> CreateSession(
      const server::SessionRequest& request) override;
  absl::StatusOr<server::SessionStatus> GetSession(const SessionId& session) override;
  std::vector<server::SessionStatus> ListSessions() override;
  absl::StatusOr<server::SessionStatus> FinishSession(const SessionId& session) override;
  absl::Status DeleteSession(const SessionId& session) override;
  absl::Status SetAckSink(const SessionId& session, server::AckSink sink) override;
  absl::Status SubmitScan(const SessionId& session, server::ScanUpload scan) override;
  absl::StatusOr<SubmapInfo> AddSubmap(Submap submap) override;
  server::MapInfo GetMapInfo() override { return info; }
  absl::StatusOr<std::vector<SubmapInfo>> ListSubmaps(const std::optional<RobotId>& robot) override;
  absl::StatusOr<server::RobotTrajectory> GetTrajectory(const RobotId& robot,
                                                        server::TrajectoryFrame frame) override;
  server::MatchGraphView GetMatchGraph() override { return graph; }
  absl::StatusOr<Match> DecideMatch(const server::MatchDecision& decision) override {
    decisions.push_back(decision);
    return decided;
  }
  absl::StatusOr<server::RobotTransform> GetTransform(const RobotId& a, const RobotId& b) override;
  std::shared_ptr<const ComposedMap> GetMap() override { return map; }
  absl::Status ExportMap(server::ExportFormat format, const Region& region,
                         double octomap_resolution_m,
                         const std::function<bool(const std::string&)>& sink) override;
  void WaitUntilIdle() override {}
  void Shutdown() override {}

  // What the readers are told. Set before use.
  server::MapInfo info;
  server::MatchGraphView graph;
  std::shared_ptr<FakeMap> map = std::make_shared<FakeMap>();
  absl::StatusOr<server::RobotTrajectory> trajectory = absl::NotFoundError("no such robot");
  absl::StatusOr<server::RobotTransform> transform = absl::NotFoundError("no such robot");
  absl::StatusOr<Match> decided = absl::NotFoundError("no such robot");
  std::vector<server::MatchDecision> decisions;  // Those asked for.
  std::vector<std::string> file;                 // Pieces ExportMap hands out.
  absl::Status export_status;                    // Returned after them.
  struct ExportCall {
    server::ExportFormat format;
    Region region;
    double octomap_resolution_m;
  };
  std::vector<ExportCall> exports;

  // While held, scans wait in a queue of `capacity`; SubmitScan waits when it is full.
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
    server::SessionStatus status;
    server::AckSink sink;
    uint64_t last_submitted = 0;
  };
  struct Queued {
    SessionId session;
    server::ScanUpload scan;
  };

  absl::StatusOr<Session*> Find(const SessionId& session);                   // mutex_ is held.
  server::ScanAck Handle(Session& session, const server::ScanUpload& scan);  // mutex_ is held.

  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<SessionId, Session> sessions_;
  std::deque<Queued> queue_;
  std::vector<Submap> submaps_;
  size_t submitted_ = 0;
  size_t capacity_ = 0;  // 0: not held.
};

}  // namespace isthmus::rpc
