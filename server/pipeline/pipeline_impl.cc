#include "server/pipeline/pipeline_impl.h"

#include <algorithm>
#include <thread>

#include "core/caught.h"
#include "core/paper.h"
#include "server/localisation/robot_localiser.h"
#include "server/pipeline/trajectory_reader.h"

namespace isthmus::server {

namespace {

// They pack submaps and wait for the disk. With two a large one does not hold up the others.
constexpr int kStoringThreads = 2;

}  // namespace

int IngestThreads(int setting) {
  if (setting > 0) return setting;
  return static_cast<int>(std::max(4u, 2 * std::thread::hardware_concurrency()));
}

absl::StatusOr<std::unique_ptr<Pipeline>> Pipeline::Open(const PipelineOptions& options,
                                                         std::unique_ptr<storage::MapStore> store,
                                                         const Clock& clock) {
  try {
    auto pipeline = std::make_unique<PipelineImpl>(options, std::move(store), clock);
    if (absl::Status status = pipeline->Start(); !status.ok()) return status;
    return pipeline;
  } catch (...) {
    return CaughtStatus();
  }
}

PipelineImpl::PipelineImpl(const PipelineOptions& options, std::unique_ptr<storage::MapStore> store,
                           const Clock& clock)
    : parts_(options, std::move(store), clock),
      sessions_(&parts_),
      reader_(&parts_.map, parts_.store.get(), &parts_.submaps, options.occupancy,
              static_cast<uint64_t>(options.octomap_cache_mb) << 20),
      decisions_(&parts_.map, parts_.store.get(), &clock, &parts_.membership) {}

PipelineImpl::~PipelineImpl() { Shutdown(); }

absl::Status PipelineImpl::Start() {
  if (!kHasPaper && parts_.options.matcher.search == matching::SearchMode::kPaper) {
    return absl::InvalidArgumentError(
        "this program was built without the paper's matching chain (ISTHMUS_PAPER=OFF): search by "
        "\"default\" or \"birds_eye\"");
  }
  if (absl::Status status = parts_.map.Load(); !status.ok()) return status;
  parts_.events.Start();
  const PipelineOptions& options = parts_.options;
  auto scans =
      ingest::ScanRecorder::Open(options.archive, options.on_problem, options.max_scan_points);
  if (!scans.ok()) return scans.status();
  parts_.scans = *std::move(scans);
  retention_ =
      std::make_unique<RetentionThread>(options.retention, &parts_.clock, RetentionHooks());
  parts_.retention = retention_.get();
  executor_ = std::make_unique<Executor>(
      Executor::Options{.threads = IngestThreads(options.ingest_threads), .name = "ingest"});
  parts_.executor = executor_.get();
  storing_ =
      std::make_unique<Executor>(Executor::Options{.threads = kStoringThreads, .name = "storing"});
  parts_.storing = storing_.get();
  placed_maps_ = std::make_unique<localisation::PlacedMaps>(
      [this] { return parts_.map.view(); },
      [this](const SubmapId& id) { return parts_.submaps.Get(id); }, &parts_.clock,
      executor_.get());
  if (absl::Status status = sessions_.Resume(); !status.ok()) return status;
  MapWriter* const map = &parts_.map;
  placement_ = std::make_unique<PlacementThread>(map, &parts_.activity, parts_.store.get(),
                                                 &parts_.clock, options.placer, options.on_problem);
  map->WaitUntilPlaced();
  composition_ = std::make_unique<CompositionThread>(
      map, &parts_.activity, [this](const SubmapId& id) { return parts_.submaps.Get(id); },
      options.composer, options.composition_interval_s, options.on_problem,
      [this](const MapView& composed_of, const std::shared_ptr<const ComposedMap>& composed) {
        map_watch_.Note(composed_of, composed);
      });
  matching_ = std::make_unique<MatchingThread>(
      map, &parts_.activity, parts_.store.get(), &parts_.submaps, &parts_.clock,
      MatchingThread::Options{options.matcher, options.loops, options.revisits,
                              options.rematch_submaps, options.prepared_bytes, options.work_journal,
                              options.on_problem});
  retention_->Start();
  store_retries_ = std::make_unique<StoreRetryThread>(&parts_.health, &parts_.workers, map,
                                                      parts_.store.get(), &parts_.membership);
  return absl::OkStatus();
}

// The inputs and the actions of the limits on robots' sessions.
RetentionThread::Hooks PipelineImpl::RetentionHooks() {
  RetentionThread::Hooks hooks;
  hooks.list = [this] {
    std::vector<ingest::StoredSession> list;
    const MapWriter::View view = parts_.map.view();
    for (const auto& [id, session] : view->sessions) {
      const SessionRecord& record = session.record;
      if (record.segment > 1) continue;  // Counted, and gone, with the first.
      list.push_back({id, record.robot, record.state == SessionState::kFinished, record.created_ns,
                      record.finished_ns, 0, 0});
    }
    return list;
  };
  hooks.map_bytes = [this](const SessionId& session) -> absl::StatusOr<uint64_t> {
    const MapWriter::View view = parts_.map.view();
    uint64_t total = 0;
    for (const SessionView* segment : view->SegmentsOf(session)) {
      const absl::StatusOr<uint64_t> bytes = parts_.store->StoredBytes(segment->record.id);
      if (!bytes.ok()) return bytes.status();
      total += *bytes;
    }
    return total;
  };
  hooks.scan_bytes = [this](const SessionId& session) { return parts_.scans->Bytes(session); };
  hooks.act = [this](const ingest::RetentionAction& action) {
    if (action.kind == ingest::RetentionAction::Kind::kDropScans) {
      return parts_.scans->FreeBytes(action.session, action.bytes);
    }
    return sessions_.DeleteSession(action.session, action.why, {});
  };
  hooks.on_problem = parts_.options.on_problem;
  return hooks;
}

absl::Status PipelineImpl::DeleteSession(const SessionId& session, const Actor& by) {
  absl::Status status = sessions_.DeleteSession(session, "", by);
  if (status.ok()) retention_->NoteChange(session);
  return status;
}

absl::StatusOr<RobotTrajectory> PipelineImpl::GetTrajectory(const RobotId& robot,
                                                            TrajectoryFrame frame,
                                                            uint32_t segment) {
  return ReadTrajectory(parts_.map, parts_.workers, *parts_.store, robot, frame, segment);
}

absl::StatusOr<std::unique_ptr<RobotLocaliser>> PipelineImpl::OpenLocaliser(
    const LocalisationRequest& request) {
  if (parts_.shut_down) return absl::UnavailableError("the server is shutting down");
  const auto sensor = floam::FindSensorModel(request.sensor);
  if (!sensor.ok()) return absl::InvalidArgumentError(sensor.status().message());
  floam::OdometryOptions options = parts_.options.odometry;
  if (request.odometry) options.mode = *request.odometry;
  if (!kHasPaper && options.mode == OdometryMode::kAloam) {
    return absl::InvalidArgumentError(
        "this program was built without the odometry \"aloam\" (ISTHMUS_PAPER=OFF)");
  }
  options.undistort_cloud = false;
  options.R_base_sensor = request.T_base_sensor.rotation();
  return localisation::MakeRobotLocaliser(*sensor, options, request.in_map_of, placed_maps_.get(),
                                          executor_.get(), &parts_.shut_down);
}

MapInfo PipelineImpl::GetMapInfo() {
  // Before the view: what scans that are done brought is in it.
  const Activity::Counters counters = parts_.activity.counters();
  const MapWriter::View view = parts_.map.view();
  MapInfo info = MapReader::Describe(*view);
  info.settled = IsSettled(counters.pending_scans, *view);
  info.composition_ms = counters.composition_ms;
  info.composition_max_ms = counters.composition_max_ms;
  info.estimation_ms = counters.estimation_ms;
  info.placement_ms = counters.placement_ms;
  info.compositions = counters.compositions;
  info.estimations = counters.estimations;
  info.placements = counters.placements;
  info.damaged = parts_.activity.damage();
  info.storage_problem = parts_.health.Problem();
  return info;
}

bool PipelineImpl::IsSettled(uint64_t pending_scans, const MapView& view) const {
  return pending_scans == 0 && view.IsPlaced() && view.IsComposed() &&
         matching_->IsUpToDateWith(view);
}

void PipelineImpl::WaitUntilIdle() {
  retention_->WaitUntilIdle();
  EventCount& changed = parts_.activity.changed();
  while (true) {
    const uint64_t seen = changed.count();
    if (parts_.shut_down) return;
    const uint64_t pending_scans = parts_.activity.counters().pending_scans;
    if (IsSettled(pending_scans, *parts_.map.view())) return parts_.events.WaitUntilStored();
    changed.WaitPast(seen);
  }
}

void PipelineImpl::StopTaking() {
  for (const auto& worker : parts_.workers.All()) worker->StopTaking();
}

void PipelineImpl::Shutdown() {
  if (parts_.shut_down.exchange(true)) return;
  if (executor_ == nullptr) return parts_.events.Stop();  // Never started.
  store_retries_ = nullptr;
  if (retention_ != nullptr) retention_->Stop();
  if (matching_ != nullptr) matching_->Stop();
  parts_.activity.changed().Notify();
  // A session whose last submap cannot be stored resumes from the one before: its robot was never
  // told that more is durable.
  for (const auto& worker : parts_.workers.All()) (void)worker->Finish();
  if (placement_ != nullptr) placement_->Stop();
  if (composition_ != nullptr) composition_->Stop();
  parts_.events.Stop();
}

}  // namespace isthmus::server
