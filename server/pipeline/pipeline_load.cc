// The pipeline's load: the work that waits, and the memory and disk that it takes.
#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "core/io/file_io.h"
#include "server/pipeline/pipeline_impl.h"

namespace isthmus::server {
namespace {

std::vector<MatchCount> CountMatches(const MapView& view) {
  std::map<std::pair<MatchState, MatchReason>, uint64_t> counts;
  for (const Match& match : *view.effective) ++counts[{match.state, match.reason}];
  std::vector<MatchCount> matches;
  for (const auto& [what, count] : counts) matches.push_back({what.first, what.second, count});
  return matches;
}

}  // namespace

ServerLoad ReadingPipeline::GetLoad() {
  const Activity::Counters counters = parts_.activity.counters();
  const MapWriter::View view = parts_.map.view();
  const PipelineOptions& options = parts_.options;
  ServerLoad load;
  AddSessions(*view, &load);
  load.localising = localising_.List();
  load.waiting_bytes = parts_.queue_room->used();
  load.waiting_bytes_limit = parts_.queue_room->limit();
  load.session_scans_limit = options.scan_queue;
  load.session_bytes_limit = parts_.queue_room->session_limit();
  load.submaps_coming_in = parts_.submaps_coming_in;
  load.matches = CountMatches(*view);
  load.placement_waits = !view->IsPlaced();
  load.composition_waits = !view->IsComposed();
  load.map_is_loading = !view->map->ready().ok();
  load.revision = view->revision->revision;
  for (const Placement& placement : view->revision->placements) {
    load.submaps += placement.submaps.size();
  }
  load.composition_ms = counters.composition_ms;
  load.placement_ms = counters.placement_ms;
  load.estimation_ms = counters.estimation_ms;
  load.compositions = counters.compositions;
  load.placements = counters.placements;
  load.estimations = counters.estimations;
  const composition::Composer::Memory composed = composition_->memory();
  load.submap_cache = {parts_.submaps.bytes(), options.submap_cache_bytes};
  load.composed = {composed.submap_bytes + composed.tile_bytes, options.composer.cache_bytes};
  load.disk = GetDiskLoad(*view, composed.spilled_bytes);
  load.storage_problem = parts_.health.Problem();
  load.now_ns = parts_.clock.NowNs();  // Last, so that nothing is of later.
  return load;
}

void ReadingPipeline::AddSessions(const MapView& view, ServerLoad* load) const {
  for (const auto& worker : parts_.workers.All()) {
    SessionLoad session = worker->Load();
    for (const SessionView* segment : view.SegmentsOf(session.session)) {
      session.submaps += segment->submaps.size();
    }
    session.map_bytes = retention_->MapBytes(session.session);
    session.scan_bytes = parts_.scans->Bytes(session.session);
    load->waiting_scans += session.waiting_scans;
    load->sessions.push_back(std::move(session));
  }
}

ServerLoad PipelineImpl::GetLoad() {
  ServerLoad load = ReadingPipeline::GetLoad();
  load.matching = matching_->Load(*parts_.map.view());
  load.prepared_maps = {matching_->prepared_bytes(), parts_.options.prepared_bytes};
  return load;
}

std::vector<RobotPlace> PipelineImpl::MappingPlaces() const {
  const MapWriter::View view = parts_.map.view();
  std::vector<RobotPlace> places;
  for (const auto& worker : parts_.workers.All()) {
    const SessionLoad load = worker->Load();
    if (!load.newest) continue;
    RobotPlace& place = places.emplace_back();
    place.robot = load.robot;
    place.session = load.session;
    place.stamp_ns = load.newest->stamp_ns;
    if (load.oldest_unacknowledged_ns > 0) {
      const int64_t waited_ns = parts_.clock.NowNs() - load.oldest_unacknowledged_ns;
      place.lag_ms = std::max(0.0, static_cast<double>(waited_ns) / 1e6);
    }
    for (const SessionView* segment : view->SegmentsOf(load.session)) {
      if (segment->record.segment != load.newest_segment) continue;
      place.session = segment->record.id;
      const Placement* placement = view->PlacementOf(place.session);
      if (placement == nullptr) continue;
      place.component = placement->component;
      place.T_map_sensor = placement->T_map_odom * load.newest->pose;
    }
  }
  return places;
}

DiskLoad ReadingPipeline::GetDiskLoad(const MapView& view, uint64_t spilled_bytes) const {
  const std::string& folder = parts_.options.archive.directory;
  if (folder.empty()) return {};
  const storage::StoreSize store = parts_.store->SizeOnDisk();
  const io::DiskSpace space = io::SpaceOf(folder);
  DiskLoad disk{store.database, store.log, 0, spilled_bytes, space.free_bytes, space.total_bytes};
  for (const auto& [id, session] : view.sessions) {
    if (session.record.segment == 1) disk.scan_bytes += parts_.scans->Bytes(id);
  }
  return disk;
}

}  // namespace isthmus::server
