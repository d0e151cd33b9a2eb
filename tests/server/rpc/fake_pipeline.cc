#include "tests/server/rpc/fake_pipeline.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "core/formats/octomap_reader.h"
#include "core/records/map_tracks.h"

namespace isthmus::rpc {

uint64_t FakeMap::point_count(uint32_t component) const {
  return component == 0 ? points_.size() : 0;
}

Box FakeMap::bounds(uint32_t) const {
  Box box;
  for (const MapPoint& point : points_) box.Extend(Eigen::Vector3d(point.x, point.y, point.z));
  return box;
}

absl::Status FakeMap::Read(const Region& region, size_t chunk, const Emit& emit) const {
  std::vector<MapPoint> found;
  uint64_t skipped = 0;
  for (const MapPoint& point : points_) {
    const Eigen::Vector3d p(point.x, point.y, point.z);
    if (region.component != 0) continue;
    if (!region.box.empty() && !region.box.Contains(p)) continue;
    if (region.has_sphere && (p - region.center).norm() > region.radius_m) continue;
    if (region.robot >= 0 && point.robot != static_cast<uint32_t>(region.robot)) continue;
    if (region.shape != nullptr && !region.shape->Contains(p)) continue;
    if (point.stamp < region.seen_from || point.stamp > region.seen_to) continue;
    if (region.keep && !region.keep(point)) continue;
    if (skipped < region.skip) {
      ++skipped;
      continue;
    }
    found.push_back(point);
    if (found.size() < chunk) continue;
    if (!emit(found)) return absl::OkStatus();
    found.clear();
  }
  if (!found.empty()) emit(found);
  return read_;
}

absl::StatusOr<FakePipeline::Session*> FakePipeline::Find(const SessionId& session) {
  const auto found = sessions_.find(session);
  if (found == sessions_.end()) {
    return absl::NotFoundError(absl::StrCat("no session \"", session.value(), "\""));
  }
  return &found->second;
}

absl::StatusOr<SessionStatus> FakePipeline::CreateSession(const SessionRequest& request,
                                                          const Actor& by) {
  actors.push_back(by);
  MutexLock lock(&mutex_);
  if (request.robot.empty()) return absl::InvalidArgumentError("the robot has no name");
  SessionStatus status;
  status.record.id = SessionId(absl::StrCat(request.robot.value(), "-", sessions_.size() + 1));
  status.record.robot = request.robot;
  status.record.sensor = request.sensor;
  status.record.odometry = request.odometry;
  status.record.T_base_sensor = request.T_base_sensor;
  status.record.created_ns = 1000;
  status.segments = 3;
  status.scans = {21, 22, 23, 24};
  status.lost_since_ns = 25;
  sessions_[status.record.id].status = status;
  return status;
}

absl::StatusOr<SessionStatus> FakePipeline::GetSession(const SessionId& session) {
  MutexLock lock(&mutex_);
  const auto found = Find(session);
  if (!found.ok()) return found.status();
  return (*found)->status;
}

std::vector<SessionStatus> FakePipeline::ListSessions() {
  MutexLock lock(&mutex_);
  std::vector<SessionStatus> list;
  for (const auto& [id, session] : sessions_) list.push_back(session.status);
  return list;
}

absl::StatusOr<SessionStatus> FakePipeline::FinishSession(const SessionId& session,
                                                          const Actor& by) {
  actors.push_back(by);
  MutexLock lock(&mutex_);
  const auto found = Find(session);
  if (!found.ok()) return found.status();
  (*found)->status.record.state = SessionState::kFinished;
  (*found)->status.record.finished_ns = 2000;
  return (*found)->status;
}

absl::Status FakePipeline::DeleteSession(const SessionId& session, const Actor& by) {
  actors.push_back(by);
  MutexLock lock(&mutex_);
  const auto found = Find(session);
  if (!found.ok()) return found.status();
  sessions_.erase(session);
  std::erase_if(queue_, [&](const Queued& queued) { return queued.session == session; });
  changed_.SignalAll();
  return absl::OkStatus();
}

absl::Status FakePipeline::SetAckSink(const SessionId& session, AckSink sink) {
  MutexLock lock(&mutex_);
  const auto found = Find(session);
  if (!found.ok()) return found.status();
  if (sink && (*found)->status.record.state == SessionState::kFinished) {
    return absl::FailedPreconditionError("the session is finished");
  }
  (*found)->sink = std::move(sink);
  return absl::OkStatus();
}

absl::StatusOr<bool> FakePipeline::OfferScan(const SessionId& session, ScanUpload* scan) {
  MutexLock lock(&mutex_);
  if (capacity_ > 0 && queue_.size() >= capacity_) return false;
  const auto found = Find(session);
  if (!found.ok()) return found.status();
  if (scan->sequence > (*found)->last_submitted + 1) {
    return absl::OutOfRangeError(absl::StrCat(
        "scan ", scan->sequence, " leaves a gap: ", (*found)->last_submitted + 1, " is expected"));
  }
  (*found)->last_submitted = std::max((*found)->last_submitted, scan->sequence);
  ++submitted_;
  if (capacity_ > 0) {
    queue_.push_back({session, std::move(*scan)});
    changed_.SignalAll();
    return true;
  }
  const ScanAck ack = Handle(**found, *scan);
  if ((*found)->sink) (*found)->sink(ack);
  return true;
}

ScanAck FakePipeline::Handle(Session& session, const ScanUpload& scan) {
  ScanAck ack;
  ack.sequence = scan.sequence;
  ack.durable_sequence = session.status.durable_sequence;
  if (scan.sequence <= session.status.last_sequence) {
    ack.outcome = ScanOutcome::kDuplicate;
    return ack;
  }
  session.status.last_sequence = scan.sequence;
  if (scan.payload.data.empty()) {
    ack.outcome = ScanOutcome::kRejected;
    ack.reason = "the scan is empty";
    return ack;
  }
  ack.tracking = Tracking::kOk;
  ack.T_odom_sensor = Pose(Eigen::Vector3d(static_cast<double>(scan.sequence), 0, 0));
  ack.timing.total_ms = 3.5;
  ack.segment = 2;
  ack.segment_session = SegmentId(session.status.record.id, 2);
  ack.lost_since_ns = 7;
  ack.scans = {11, 12, 13, 14};
  // Every entry differs, so that none can take another's place on the way.
  Matrix6d covariance;
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) covariance(i, k) = 10 * std::min(i, k) + std::max(i, k);
  }
  ack.covariance = covariance;
  ack.unobserved_translations = {{1, 0, 0}, {0, 0.6, 0.8}};
  ack.unobserved_rotations = {{0, 0, 1}};
  return ack;
}

absl::StatusOr<SubmapInfo> FakePipeline::AddSubmap(Submap submap) {
  MutexLock lock(&mutex_);
  submaps_.push_back(std::move(submap));
  return Summarize(submaps_.back());
}

absl::StatusOr<ListAt<SubmapStatus>> FakePipeline::ListSubmaps(
    const std::optional<RobotId>& robot) {
  MutexLock lock(&mutex_);
  ListAt<SubmapStatus> list;
  list.revision = info.revision;
  for (const Submap& submap : submaps_) {
    if (robot && submap.robot != *robot) continue;
    SubmapStatus status{Summarize(submap), std::nullopt, Pose()};
    if (const auto found = placed.find(ToString(submap.id)); found != placed.end()) {
      status.component = 1;
      status.T_map_submap = found->second;
    }
    list.push_back(std::move(status));
  }
  if (robot && list.empty()) return absl::NotFoundError("no such robot");
  return list;
}

absl::StatusOr<ListAt<Loop>> FakePipeline::ListLoops(const std::optional<RobotId>& robot) {
  asked_robot = robot;
  if (!loops.ok()) return loops.status();
  ListAt<Loop> list{*loops};
  list.revision = info.revision;
  return list;
}

absl::StatusOr<DecidedLoop> FakePipeline::DecideLoop(const LoopDecision& decision,
                                                     const Actor& by) {
  actors.push_back(by);
  loop_decisions.push_back(decision);
  return decided_loop;
}

absl::StatusOr<int64_t> FakePipeline::PutAnchor(Anchor anchor, const Actor& by) {
  actors.push_back(by);
  anchors.push_back(std::move(anchor));
  return anchored;
}

std::shared_ptr<const server::MapView> FakePipeline::View() const {
  auto view = std::make_shared<server::MapView>();
  view->map = map;
  {
    MutexLock lock(&mutex_);
    for (const auto& [id, session] : sessions_) {
      server::SessionView records;
      records.record = session.status.record;
      for (const Submap& submap : submaps_) {
        if (submap.id.session != id) continue;
        records.submaps.Set(submap.id.index, std::make_shared<const SubmapInfo>(Summarize(submap)));
      }
      view->sessions.Set(id, std::make_shared<const server::SessionView>(std::move(records)));
    }
  }
  auto revision = std::make_shared<MapRevision>();
  MutexLock lock(&load_mutex);
  revision->revision = load.revision;
  view->composed_revision = load.composition_waits ? -1 : load.revision;
  view->revision = std::move(revision);
  return view;
}

ListAt<RobotAnchor> FakePipeline::ListAnchors(const server::MapView&) const {
  MutexLock lock(&mutex_);
  ListAt<RobotAnchor> list;
  list.revision = info.revision;
  for (const Anchor& anchor : anchors) {
    const auto found = sessions_.find(anchor.submap.session);
    list.push_back(
        {anchor, found == sessions_.end() ? RobotId() : found->second.status.record.robot});
  }
  return list;
}

absl::StatusOr<int64_t> FakePipeline::UndoRevision(int64_t revision, const std::string& note,
                                                   const Actor& by) {
  actors.push_back(by);
  undone.emplace_back(revision, note);
  return undo;
}

absl::StatusOr<std::vector<Track>> FakePipeline::GetTracks(const server::MapView& view,
                                                           const MapName& map_name) const {
  const TrackSource source = {[&] { return info; },
                              [&] {
                                MutexLock lock(&mutex_);
                                std::vector<SessionRecord> records;
                                for (const auto& [id, session] : sessions_)
                                  records.push_back(session.status.record);
                                return records;
                              },
                              [&](const SessionId& opened, uint32_t segment) {
                                return GetTrajectory(view, RobotId(opened.value()),
                                                     TrajectoryFrame::kMap, segment);
                              }};
  return ReadTracks(source, info, map_name);
}

absl::StatusOr<FreeSpace> FakePipeline::ReadFreeSpace(const server::MapView&,
                                                      const ExportRequest& wanted,
                                                      uint64_t max_file_bytes,
                                                      const std::function<bool()>&) const {
  exports.push_back(wanted);
  const std::string bytes = absl::StrJoin(file, "");
  if (bytes.size() > max_file_bytes) return absl::ResourceExhaustedError("too large");
  FreeSpace space;
  const auto resolution_m = formats::ParseOctomapBinary(
      bytes, [&space](const VoxelCube& cube) { space.cubes.push_back(cube); });
  if (!resolution_m.ok()) return resolution_m.status();
  space.resolution_m = *resolution_m;
  return space;
}

absl::StatusOr<RobotTrajectory> FakePipeline::GetTrajectory(const server::MapView&, const RobotId&,
                                                            TrajectoryFrame,
                                                            uint32_t segment) const {
  trajectory_segment = segment;
  absl::StatusOr<RobotTrajectory> answer = trajectory;
  if (answer.ok() && answer->parts.empty()) answer->parts = {{1, answer->poses.size()}};
  return answer;
}

absl::StatusOr<RobotTransform> FakePipeline::GetTransform(const RobotId&, const RobotId&) const {
  return transform;
}

absl::Status FakePipeline::ExportMap(const ExportRequest& request,
                                     const std::function<void(int64_t)>& begin,
                                     const std::function<bool(const std::string&)>& sink) const {
  exports.push_back(request);
  begin(map->revision());
  for (const std::string& piece : file) {
    if (!sink(piece)) return absl::CancelledError("the reader went away");
  }
  return export_status;
}

absl::StatusOr<EventPage> FakePipeline::ListEvents(const EventQuery& query) {
  return log_->ListEvents(query);
}

void FakePipeline::NoteEvent(Event event) { Note({std::move(event)}); }

void FakePipeline::Note(const std::vector<Event>& events) {
  EXPECT_TRUE(log_->Write({.events = events}).ok());
  std::vector<std::function<void()>> wakes;
  {
    MutexLock lock(&mutex_);
    for (const auto& [handle, wake] : wakes_) wakes.push_back(wake);
  }
  for (const auto& wake : wakes) wake();
}

uint64_t FakePipeline::OnEvents(std::function<void()> wake) {
  MutexLock lock(&mutex_);
  wakes_.emplace(next_wake_, std::move(wake));
  return next_wake_++;
}

void FakePipeline::ForgetEvents(uint64_t handle) {
  MutexLock lock(&mutex_);
  wakes_.erase(handle);
}

void FakePipeline::Hold(size_t capacity) {
  MutexLock lock(&mutex_);
  capacity_ = capacity;
}

void FakePipeline::Release() {
  MutexLock lock(&mutex_);
  capacity_ = 0;
  for (const Queued& queued : queue_) {
    Session& session = sessions_.at(queued.session);
    const ScanAck ack = Handle(session, queued.scan);
    if (session.sink) session.sink(ack);
  }
  queue_.clear();
  changed_.SignalAll();
}

size_t FakePipeline::Waiting() {
  MutexLock lock(&mutex_);
  return queue_.size();
}

void FakePipeline::WaitForQueued(size_t scans) {
  MutexLock lock(&mutex_);
  while (queue_.size() < scans) changed_.Wait(&mutex_);
}

void FakePipeline::MakeDurable(const SessionId& session, uint64_t sequence) {
  MutexLock lock(&mutex_);
  Session& found = sessions_.at(session);
  found.status.durable_sequence = sequence;
  ScanAck ack;
  ack.durable_sequence = sequence;
  if (found.sink) found.sink(ack);
}

std::vector<Submap> FakePipeline::submaps() {
  MutexLock lock(&mutex_);
  return submaps_;
}

size_t FakePipeline::submitted() {
  MutexLock lock(&mutex_);
  return submitted_;
}

std::optional<MapStep> FakePipeline::Since(const MapMark& known, uint32_t) {
  MutexLock lock(&mutex_);
  if (steps_.empty()) return std::nullopt;
  MapStep step = steps_.back();
  step.restart = known.run != step.mark.run;
  if (known.revision == step.mark.revision && !step.restart) {
    MapStep none;
    none.mark = step.mark;
    return none;
  }
  return step;
}

std::vector<RobotPlace> FakePipeline::RobotPlaces() {
  MutexLock lock(&mutex_);
  return places_;
}

uint64_t FakePipeline::OnChange(std::function<void()> wake) {
  MutexLock lock(&mutex_);
  map_wakes_[next_wake_] = std::move(wake);
  return next_wake_++;
}

void FakePipeline::Forget(uint64_t handle) {
  MutexLock lock(&mutex_);
  map_wakes_.erase(handle);
}

void FakePipeline::ShowStep(MapStep step) {
  std::vector<std::function<void()>> wakes;
  {
    MutexLock lock(&mutex_);
    steps_.push_back(std::move(step));
    for (const auto& [handle, wake] : map_wakes_) wakes.push_back(wake);
  }
  for (const auto& wake : wakes) wake();
}

void FakePipeline::PutRobots(std::vector<RobotPlace> places) {
  MutexLock lock(&mutex_);
  places_ = std::move(places);
}

}  // namespace isthmus::rpc
