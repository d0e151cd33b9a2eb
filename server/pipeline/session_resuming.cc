// Workers of sessions: new ones, and those that go on after a restart.
#include <absl/strings/str_cat.h>

#include <utility>

#include "core/caught.h"
#include "core/paper.h"
#include "floam/rings/sensor_model.h"
#include "server/pipeline/session_manager.h"

namespace isthmus::server {
namespace {

// A robot with its own SLAM sends submaps; their keyframes come from no scan.
bool HasUploads(const SessionView& session, SubmapCache* cache) {
  for (const auto& [index, submap] : session.submaps) {
    const auto outline = cache->TryOutline(submap.id);
    if (absl::IsUnavailable(outline.status())) throw StatusError(outline.status());
    if (outline.ok()) return (*outline)->keyframes.front().sequence == 0;
  }
  return false;
}

}  // namespace

absl::Status SessionManager::Resume() {
  const MapWriter::View view = parts_.map.view();
  NoteNumbers(*view);
  for (const auto& [id, session] : view->sessions) {
    const SessionRecord& record = session.record;
    if (record.state == SessionState::kFinished || record.segment > 1) continue;
    absl::Status resumed;
    try {
      resumed = Resume(session);
    } catch (...) {
      resumed = CaughtStatus();
    }
    // A start that can be tried again must lose nothing.
    if (absl::IsUnavailable(resumed)) return resumed;
    if (resumed.ok() || !parts_.options.on_problem) continue;
    parts_.options.on_problem(absl::StrCat(
        "session ", id.value(), " cannot go on: ", resumed.message(), "; its map is served"));
  }
  return absl::OkStatus();
}

absl::Status SessionManager::Resume(const SessionView& session) {
  absl::StatusOr<Worker> worker = ResumeWorker(session);
  if (!worker.ok()) return worker.status();
  parts_.workers.Add(session.record.id, *std::move(worker));
  // A finished session takes neither scans nor submaps.
  if (HasUploads(session, &parts_.submaps)) parts_.workers.NoteUploads(session.record.id);
  return absl::OkStatus();
}

absl::StatusOr<SessionManager::Worker> SessionManager::ResumeWorker(const SessionView& session) {
  const SessionRecord& record = session.record;
  const MapWriter::View view = parts_.map.view();
  ingest::ResumePoint resume;
  auto checkpoint = ReadCheckpoint(record.id);
  if (!checkpoint.ok()) return checkpoint.status();
  resume.checkpoint = *std::move(checkpoint);
  for (const SessionView* segment : view->SegmentsOf(record.id)) {
    absl::StatusOr<ingest::StoredSegment> stored = ReadSegment(*segment);
    if (!stored.ok()) return stored.status();
    resume.segments.push_back(*std::move(stored));
  }
  auto worker = MakeWorkerWithOrWithoutCheckpoint(record, &resume);
  if (!worker.ok() || !parts_.options.on_problem) return worker;
  if (const std::string resumed = (*worker)->Status().resumed; !resumed.empty()) {
    parts_.options.on_problem(absl::StrCat("session ", record.id.value(), " was ", resumed,
                                           "; it does not go on exactly as it was"));
  }
  return worker;
}

absl::StatusOr<SessionManager::Worker> SessionManager::MakeWorkerWithOrWithoutCheckpoint(
    const SessionRecord& record, ingest::ResumePoint* resume) {
  try {
    return MakeWorker(record, *resume);
  } catch (const StatusError&) {
    throw;
  } catch (...) {
    if (!resume->checkpoint) throw;
    resume->checkpoint->state = std::nullopt;  // As if it were damaged.
    return MakeWorker(record, *resume);
  }
}

absl::StatusOr<ingest::StoredSegment> SessionManager::ReadSegment(const SessionView& session) {
  auto trajectory = parts_.store->GetTrajectory(session.record.id);
  if (!trajectory.ok()) return trajectory.status();
  ingest::StoredSegment stored;
  stored.segment = session.record.segment;
  stored.trajectory = *std::move(trajectory);
  stored.next_index = session.next_index();
  if (!session.submaps.empty()) stored.last_sequence = session.submaps.back().last_sequence;
  stored.for_each_submap =
      [this, submaps = session.submaps](const std::function<void(const Submap&)>& visit) {
        for (const auto& [index, submap] : submaps) {
          if (const auto whole = parts_.submaps.GetOrThrow(submap.id)) visit(*whole);
        }
      };
  return stored;
}

absl::StatusOr<std::optional<SessionCheckpoint>> SessionManager::ReadCheckpoint(
    const SessionId& session) const {
  absl::StatusOr<storage::Checkpoint> stored = parts_.store->GetCheckpoint(session);
  if (absl::IsNotFound(stored.status())) return std::nullopt;
  if (absl::IsUnavailable(stored.status())) return stored.status();
  if (!stored.ok()) return SessionCheckpoint();  // Damaged: the worker goes on from the submaps.
  return SessionCheckpoint{stored->sequence, stored->durable_sequence, std::move(stored->data)};
}

absl::StatusOr<SessionManager::Worker> SessionManager::MakeWorker(
    const SessionRecord& record, const ingest::ResumePoint& resume) {
  absl::StatusOr<floam::SensorModel> sensor = floam::FindSensorModel(record.sensor);
  if (!sensor.ok()) {
    return absl::InvalidArgumentError(sensor.status().message());
  }
  const PipelineOptions& given = parts_.options;
  ingest::SessionWorker::Options options;
  options.queue = given.scan_queue;
  options.queue_bytes = parts_.queue_room->session_limit();
  options.max_points = given.max_scan_points;
  options.max_rate_hz = given.max_scan_rate_hz;
  options.odometry = given.odometry;
  options.submap = given.submap;
  options.room = parts_.queue_room;
  options.storing = parts_.storing;
  options.clock = &parts_.clock;
  options.observer = given.observer;
  if (record.odometry) options.odometry.mode = *record.odometry;
  if (!kHasPaper && options.odometry.mode == OdometryMode::kAloam) {
    return absl::InvalidArgumentError(
        "this program was built without the odometry \"aloam\" (ISTHMUS_PAPER=OFF)");
  }
  return ingest::SessionWorker::Create(record, *sensor, options, HooksOf(record.id),
                                       parts_.executor, resume);
}

ingest::WorkerHooks SessionManager::HooksOf(const SessionId& session) {
  ingest::WorkerHooks hooks;
  hooks.persist = [this, session](const FinishedSubmap& finished) {
    const StageTimer timer(finished.submap ? parts_.options.observer : nullptr, Stage::kStore);
    if (absl::Status kept = parts_.scans->Sync(session); !kept.ok()) return kept;
    absl::Status stored = parts_.map.AddSubmap(session, finished);
    if (stored.ok()) parts_.retention->NoteChange(session);
    return stored;
  };
  hooks.T_map_odom = [this, session](uint32_t segment) -> std::optional<Pose> {
    const MapWriter::View view = parts_.map.view();
    const Placement* placement = view->PlacementOf(SegmentId(session, segment));
    if (placement == nullptr) return std::nullopt;
    return placement->T_map_odom;
  };
  hooks.scan_done = [this] { parts_.activity.ScanDone(); };
  hooks.tell = [this](Event event) { parts_.events.Note(std::move(event)); };
  return hooks;
}

}  // namespace isthmus::server
