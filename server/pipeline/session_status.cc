// The status of sessions.
#include <absl/strings/str_cat.h>

#include <algorithm>

#include "server/pipeline/session_manager.h"

namespace isthmus::server {

namespace {

// True if a robot uploaded the session's submaps. Such submaps number their keyframes, not scans,
// and there is no scan between two of them.
bool IsUploaded(const SessionView& session) {
  if (session.record.scans != ScanCounts{}) return false;
  for (const auto& [index, submap] : session.submaps) {
    if (submap.keyframe_count != submap.last_sequence - submap.first_sequence + 1) return false;
  }
  return true;
}

// The number of a finished session's last scan, which no submap holds if it was lost, rejected or
// skipped.
uint64_t CountedScans(const ScanCounts& counts) {
  return counts.ok + counts.degenerate + counts.lost + counts.rejected + counts.skipped;
}

// Along the stored submaps: what is known of a session that was not open since the server started.
double StoredWay(const std::vector<const SessionView*>& segments) {
  double way_m = 0;
  for (const SessionView* segment : segments) {
    for (const auto& [index, length_m] : segment->path_length_m) way_m += length_m;
  }
  return way_m;
}

}  // namespace

SessionStatus SessionManager::StatusOf(const MapView& view, const SessionView& session) const {
  SessionStatus status;
  status.record = session.record;
  status.submap_count = static_cast<uint32_t>(session.submaps.size());
  status.point_count = session.points;
  if (const Placement* placement = view.PlacementOf(session.record.id)) {
    status.component = placement->component;
    status.T_map_odom = placement->T_map_odom;
  }
  status.quota_bytes = parts_.options.retention.LimitsOf(session.record.robot).quota_bytes;
  if (session.record.segment == 1) {
    FillStreamStatus(view, session, &status);
  } else if (!session.submaps.empty()) {
    status.last_sequence = status.durable_sequence = session.submaps.back().last_sequence;
  }
  return status;
}

void SessionManager::FillStreamStatus(const MapView& view, const SessionView& session,
                                      SessionStatus* status) const {
  const SessionId& id = session.record.id;
  const ingest::SessionWorkers::Entry entry = parts_.workers.Find(id);
  const ingest::WorkerStatus worker =
      entry.worker != nullptr ? entry.worker->Status() : entry.final_status;
  status->last_sequence = worker.last_sequence;
  status->durable_sequence = worker.durable_sequence;
  status->scans_processed = worker.processed;
  status->scans_rejected = worker.rejected;
  status->odometry_ms_mean = worker.odometry_ms_mean;
  status->tracking = worker.tracking;
  status->input = worker.input;
  status->scans = entry.worker != nullptr ? worker.scans : session.record.scans;
  status->lost_since_ns = worker.lost_since_ns;
  const std::vector<const SessionView*> segments = view.SegmentsOf(id);
  const auto note_stored = [status](uint64_t sequence) {
    status->last_sequence = std::max(status->last_sequence, sequence);
    status->durable_sequence = std::max(status->durable_sequence, sequence);
  };
  if (entry.worker == nullptr) note_stored(CountedScans(session.record.scans));
  status->segments = std::max(worker.segment, segments.back()->record.segment);
  status->travelled_m = worker.travelled_m > 0 ? worker.travelled_m : StoredWay(segments);
  for (const SessionView* segment : segments) {
    if (entry.worker != nullptr || entry.uploads || segment->submaps.empty()) continue;
    if (!IsUploaded(*segment)) note_stored(segment->submaps.back().last_sequence);
  }
  status->map_bytes = parts_.retention->MapBytes(id);
  status->scan_bytes = parts_.scans->Bytes(id);
  status->archive_problem = parts_.scans->Problem(id);
}

absl::StatusOr<SessionStatus> SessionManager::Get(const SessionId& session) const {
  const MapWriter::View view = parts_.map.view();
  const SessionView* known = view->Find(session);
  if (known != nullptr) return StatusOf(*view, *known);
  const absl::Status unknown = UnknownSession(session), takes = parts_.check_takes_changes();
  if (takes.ok()) return unknown;
  return absl::UnavailableError(absl::StrCat(unknown.message(), " (", takes.message(), ")"));
}

std::vector<SessionStatus> SessionManager::List() const {
  const MapWriter::View view = parts_.map.view();
  std::vector<SessionStatus> list;
  for (const SessionView* session : view->InOrder()) list.push_back(StatusOf(*view, *session));
  return list;
}

}  // namespace isthmus::server
