#include "server/pipeline/reading_pipeline.h"

#include <algorithm>
#include <iterator>

#include "core/paper.h"
#include "server/localisation/robot_localiser.h"

namespace isthmus::server {

ReadingPipeline::ReadingPipeline(const PipelineOptions& options,
                                 std::unique_ptr<storage::MapStore> store, const Clock& clock)
    : parts_(options, std::move(store), clock, [this] { return CheckTakesChanges(); }),
      sessions_(&parts_),
      decisions_(&parts_),
      reader_(&parts_.map, parts_.store.get(), &parts_.submaps, &parts_.workers, options.occupancy,
              static_cast<uint64_t>(options.octomap_cache_mb) << 20),
      localising_(&parts_.clock) {}

absl::Status ReadingPipeline::OpenParts(
    std::function<absl::Status(const ingest::RetentionAction&)> act) {
  const PipelineOptions& options = parts_.options;
  auto scans =
      ingest::ScanRecorder::Open(options.archive, options.on_problem, options.max_scan_points);
  if (!scans.ok()) return scans.status();
  parts_.scans = *std::move(scans);
  retention_ = std::make_unique<RetentionThread>(options.retention, &parts_.clock,
                                                 RetentionHooks(std::move(act)));
  parts_.retention = retention_.get();
  executor_ = std::make_unique<Executor>(
      Executor::Options{.threads = IngestThreads(options.ingest_threads), .name = "ingest"});
  parts_.executor = executor_.get();
  localisation_maps_ = std::make_unique<localisation::LocalisationMaps>(
      [this] { return parts_.map.view(); },
      [this](const SubmapId& id) { return parts_.submaps.GetOrThrow(id); }, &parts_.clock,
      executor_.get());
  return absl::OkStatus();
}

void ReadingPipeline::StartPlacing(storage::MapStore* store) {
  placement_ =
      std::make_unique<PlacementThread>(&parts_.map, &parts_.activity, store, &parts_.clock,
                                        parts_.options.placer, parts_.options.on_problem);
}

void ReadingPipeline::StartComposing() {
  const PipelineOptions& options = parts_.options;
  composition_ = std::make_unique<CompositionThread>(
      &parts_.map, &parts_.activity,
      [this](const SubmapId& id) { return parts_.submaps.GetOrThrow(id); }, options.composer,
      options.composition_interval_s, options.on_problem,
      [this](const MapView& composed_of, const std::shared_ptr<const ComposedMap>& composed) {
        map_watch_.Note(composed_of, composed);
        if (composed->waiting_submaps() == 0) told_revision_ = composed->revision();
        parts_.activity.changed().Notify();
      });
}

RetentionThread::Hooks ReadingPipeline::RetentionHooks(
    std::function<absl::Status(const ingest::RetentionAction&)> act) {
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
  hooks.act = std::move(act);
  hooks.on_problem = parts_.options.on_problem;
  return hooks;
}

absl::StatusOr<std::unique_ptr<RobotLocaliser>> ReadingPipeline::OpenLocaliser(
    const LocalisationRequest& request) {
  if (parts_.shut_down) return absl::UnavailableError("the server is shutting down");
  if (absl::Status status =
          request.robot.empty() ? absl::OkStatus() : CheckRobotName(request.robot);
      !status.ok()) {
    return status;
  }
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
  return localisation::MakeRobotLocaliser(*sensor, options, request, localisation_maps_.get(),
                                          &localising_, executor_.get(), &parts_.shut_down);
}

std::vector<RobotPlace> ReadingPipeline::RobotPlaces() {
  std::vector<RobotPlace> places = MappingPlaces();
  std::ranges::move(localising_.List(), std::back_inserter(places));
  return places;
}

MapInfo ReadingPipeline::GetMapInfo() {
  // Before the view: what scans that are done brought is in it.
  const Activity::Counters counters = parts_.activity.counters();
  const MapWriter::View view = parts_.map.view();
  MapInfo info = reader_.Describe(*view);
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
  const std::string awaited = parts_.activity.awaited();
  if (info.storage_problem.empty() && !awaited.empty()) {
    info.storage_problem = "the merged map waits for what is stored: " + awaited;
  }
  // Submaps wait to be stored, or to be read.
  info.settled = info.settled && info.storage_problem.empty();
  return info;
}

bool ReadingPipeline::IsSettled(uint64_t pending_scans, const MapView& view) const {
  return pending_scans == 0 && view.IsPlaced() && view.IsComposed() &&
         told_revision_ >= view.revision->revision;
}

void ReadingPipeline::WaitUntilSettled() {
  EventCount& changed = parts_.activity.changed();
  while (!parts_.shut_down) {
    const uint64_t seen = changed.count();
    const uint64_t pending_scans = parts_.activity.counters().pending_scans;
    if (parts_.shut_down || IsSettled(pending_scans, *parts_.map.view())) return;
    changed.WaitPast(seen);
  }
}

}  // namespace isthmus::server
