#include "api/convert/status.h"

#include <utility>

#include "api/convert/map.h"
#include "api/convert/map_changes.h"
#include "api/convert/session.h"

namespace isthmus::convert {
namespace {

v1::SessionLoad SessionMessage(const SessionLoad& load) {
  v1::SessionLoad message;
  message.set_session(load.session.value());
  message.set_robot(load.robot.value());
  message.set_tracking(ToMessage(load.tracking));
  message.set_waiting_scans(load.waiting_scans);
  message.set_waiting_bytes(load.waiting_bytes);
  message.set_received_sequence(load.received_sequence);
  message.set_acknowledged_sequence(load.acknowledged_sequence);
  message.set_durable_sequence(load.durable_sequence);
  message.set_received_ns(load.received_ns);
  message.set_ack_delay_ns(load.ack_delay_ns);
  message.set_oldest_unacknowledged_ns(load.oldest_unacknowledged_ns);
  message.set_oldest_undurable_ns(load.oldest_undurable_ns);
  message.set_scans_processed(load.scans_processed);
  message.set_scans_rejected(load.scans_rejected);
  message.set_scans_skipped(load.scans_skipped);
  message.set_lost_since_ns(load.lost_since_ns);
  message.set_submaps(load.submaps);
  message.set_map_bytes(load.map_bytes);
  message.set_scan_bytes(load.scan_bytes);
  return message;
}

SessionLoad SessionOf(const v1::SessionLoad& message) {
  SessionLoad load;
  load.session = SessionId(message.session());
  load.robot = RobotId(message.robot());
  load.tracking = FromMessage(message.tracking());
  load.waiting_scans = message.waiting_scans();
  load.waiting_bytes = message.waiting_bytes();
  load.received_sequence = message.received_sequence();
  load.acknowledged_sequence = message.acknowledged_sequence();
  load.durable_sequence = message.durable_sequence();
  load.received_ns = message.received_ns();
  load.ack_delay_ns = message.ack_delay_ns();
  load.oldest_unacknowledged_ns = message.oldest_unacknowledged_ns();
  load.oldest_undurable_ns = message.oldest_undurable_ns();
  load.scans_processed = message.scans_processed();
  load.scans_rejected = message.scans_rejected();
  load.scans_skipped = message.scans_skipped();
  load.lost_since_ns = message.lost_since_ns();
  load.submaps = message.submaps();
  load.map_bytes = message.map_bytes();
  load.scan_bytes = message.scan_bytes();
  return load;
}

void FillCache(const CacheLoad& load, v1::CacheLoad* message) {
  message->set_bytes(load.bytes);
  message->set_limit_bytes(load.limit_bytes);
}

CacheLoad CacheOf(const v1::CacheLoad& message) { return {message.bytes(), message.limit_bytes()}; }

void FillProcess(const ProcessUse& load, v1::ProcessUse* message) {
  message->set_cpu_s(load.cpu_s);
  message->set_resident_bytes(load.resident_bytes);
  message->set_threads(load.threads);
  message->set_open_files(load.open_files);
  message->set_open_files_limit(load.open_files_limit);
}

ProcessUse ProcessOf(const v1::ProcessUse& message) {
  ProcessUse load;
  load.cpu_s = message.cpu_s();
  load.resident_bytes = message.resident_bytes();
  load.threads = message.threads();
  load.open_files = message.open_files();
  load.open_files_limit = message.open_files_limit();
  return load;
}

void FillCalls(const RunningCallCounts& load, v1::RunningCalls* message) {
  message->set_streams(load.streams);
  message->set_queries(load.queries);
  message->set_exports(load.exports);
  message->set_lists(load.lists);
  message->set_others(load.others);
}

RunningCallCounts CallsOf(const v1::RunningCalls& message) {
  RunningCallCounts load;
  load.streams = message.streams();
  load.queries = message.queries();
  load.exports = message.exports();
  load.lists = message.lists();
  load.others = message.others();
  return load;
}

void FillDisk(const DiskLoad& load, v1::DiskLoad* message) {
  message->set_database_bytes(load.database_bytes);
  message->set_log_bytes(load.log_bytes);
  message->set_scan_bytes(load.scan_bytes);
  message->set_spilled_bytes(load.spilled_bytes);
  message->set_free_bytes(load.free_bytes);
  message->set_total_bytes(load.total_bytes);
}

DiskLoad DiskOf(const v1::DiskLoad& message) {
  DiskLoad load;
  load.database_bytes = message.database_bytes();
  load.log_bytes = message.log_bytes();
  load.scan_bytes = message.scan_bytes();
  load.spilled_bytes = message.spilled_bytes();
  load.free_bytes = message.free_bytes();
  load.total_bytes = message.total_bytes();
  return load;
}

void FillMatching(const MatchingLoad& load, v1::MatchingLoad* message) {
  message->set_idle(load.is_idle);
  message->set_submaps(load.submaps);
  message->set_pairs(load.pairs);
  message->set_workers(load.workers);
  message->set_jobs(load.jobs);
  message->set_jobs_set_aside(load.jobs_set_aside);
}

MatchingLoad MatchingOf(const v1::MatchingLoad& message) {
  MatchingLoad load;
  load.is_idle = message.idle();
  load.submaps = message.submaps();
  load.pairs = message.pairs();
  load.workers = message.workers();
  load.jobs = message.jobs();
  load.jobs_set_aside = message.jobs_set_aside();
  return load;
}

void FillLoad(const ServerLoad& load, v1::ServerStatus* message) {
  message->set_now_ns(load.now_ns);
  message->set_placement_waits(load.placement_waits);
  message->set_composition_waits(load.composition_waits);
  message->set_map_is_loading(load.map_is_loading);
  message->set_revision(load.revision);
  message->set_submaps(load.submaps);
  message->set_composition_ms(load.composition_ms);
  message->set_placement_ms(load.placement_ms);
  message->set_estimation_ms(load.estimation_ms);
  message->set_compositions(load.compositions);
  message->set_placements(load.placements);
  message->set_estimations(load.estimations);
  message->set_storage_problem(load.storage_problem);
  if (load.replica) *message->mutable_replica() = ToMessage(*load.replica);
  message->set_submaps_coming_in(load.submaps_coming_in);
  for (const SessionLoad& session : load.sessions) {
    *message->add_sessions() = SessionMessage(session);
  }
  for (const RobotPlace& place : load.localising) *message->add_localising() = ToMessage(place);
  v1::QueueLoad& queues = *message->mutable_queues();
  queues.set_scans(load.waiting_scans);
  queues.set_bytes(load.waiting_bytes);
  queues.set_bytes_limit(load.waiting_bytes_limit);
  queues.set_session_scans_limit(load.session_scans_limit);
  queues.set_session_bytes_limit(load.session_bytes_limit);
  FillMatching(load.matching, message->mutable_matching());
  FillCache(load.submap_cache, message->mutable_submap_cache());
  FillCache(load.prepared_maps, message->mutable_prepared_maps());
  FillCache(load.composed, message->mutable_composed());
  FillDisk(load.disk, message->mutable_disk());
}

ServerLoad LoadOf(const v1::ServerStatus& message) {
  ServerLoad load;
  load.now_ns = message.now_ns();
  load.placement_waits = message.placement_waits();
  load.composition_waits = message.composition_waits();
  load.map_is_loading = message.map_is_loading();
  load.revision = message.revision();
  load.submaps = message.submaps();
  load.composition_ms = message.composition_ms();
  load.placement_ms = message.placement_ms();
  load.estimation_ms = message.estimation_ms();
  load.compositions = message.compositions();
  load.placements = message.placements();
  load.estimations = message.estimations();
  load.storage_problem = message.storage_problem();
  if (message.has_replica()) load.replica = FromMessage(message.replica());
  load.submaps_coming_in = message.submaps_coming_in();
  for (const v1::SessionLoad& session : message.sessions()) {
    load.sessions.push_back(SessionOf(session));
  }
  for (const v1::RobotPlace& place : message.localising()) {
    load.localising.push_back(FromMessage(place));
  }
  load.waiting_scans = message.queues().scans();
  load.waiting_bytes = message.queues().bytes();
  load.waiting_bytes_limit = message.queues().bytes_limit();
  load.session_scans_limit = message.queues().session_scans_limit();
  load.session_bytes_limit = message.queues().session_bytes_limit();
  load.matching = MatchingOf(message.matching());
  load.submap_cache = CacheOf(message.submap_cache());
  load.prepared_maps = CacheOf(message.prepared_maps());
  load.composed = CacheOf(message.composed());
  load.disk = DiskOf(message.disk());
  return load;
}

}  // namespace

v1::ServerStatus ToMessage(const ServerStatus& status) {
  v1::ServerStatus message;
  message.set_version(status.version);
  message.set_site(status.site);
  message.set_started_ns(status.started_ns);
  message.set_uptime_s(status.uptime_s);
  message.set_uploads(status.uploads);
  FillProcess(status.process, message.mutable_process());
  FillCalls(status.calls, message.mutable_calls());
  for (const DegradedService& degraded : status.degraded) {
    v1::DegradedService& one = *message.add_degraded();
    one.set_service(degraded.service);
    one.set_why(degraded.why);
  }
  FillLoad(status.load, &message);
  message.set_web_address(status.web_address);
  for (const RefusedMethod& refused : status.refused) {
    v1::RefusedMethod& one = *message.add_refused();
    one.set_method(refused.method);
    one.set_why(refused.why);
  }
  return message;
}

ServerStatus FromMessage(const v1::ServerStatus& message) {
  ServerStatus status;
  status.version = message.version();
  status.site = message.site();
  status.started_ns = message.started_ns();
  status.uptime_s = message.uptime_s();
  status.uploads = message.uploads();
  status.process = ProcessOf(message.process());
  status.calls = CallsOf(message.calls());
  for (const v1::DegradedService& degraded : message.degraded()) {
    status.degraded.push_back({degraded.service(), degraded.why()});
  }
  status.load = LoadOf(message);
  status.web_address = message.web_address();
  for (const v1::RefusedMethod& refused : message.refused()) {
    status.refused.push_back({refused.method(), refused.why()});
  }
  return status;
}

}  // namespace isthmus::convert
