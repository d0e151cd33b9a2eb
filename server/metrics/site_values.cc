#include "server/metrics/site_values.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "core/map/match.h"
#include "core/records/server_load.h"
#include "server/metrics/prometheus_values.h"

namespace isthmus::metrics {
namespace {

// Seconds from a time to a later one; none where the earlier one is not known.
double Since(int64_t then_ns, int64_t now_ns) {
  return then_ns == 0 ? 0 : std::max(0.0, 1e-9 * static_cast<double>(now_ns - then_ns));
}

uint64_t Minus(uint64_t all, uint64_t some) { return all - std::min(all, some); }

// The open sessions of one robot, or of all that share a name: scans added up, times the worst.
struct RobotLag {
  uint64_t unacknowledged = 0, undurable = 0, lost = 0;
  double ack_lag_s = 0, durable_lag_s = 0;
};

void AddLocalising(const ServerLoad& load, RobotNames* names, Values* values) {
  std::map<std::pair<std::string, LocalisationState>, uint64_t> states;
  for (const RobotPlace& place : load.localising) {
    ++states[{names->NameOf(place.robot), place.localising->state}];
  }
  for (const auto& [what, streams] : states) {
    values->Gauge("isthmus_robot_localising",
                  "Streams on which it asks where it is, by the answer.", streams,
                  {{"robot", what.first}, {"state", ToString(what.second)}});
  }
}

// The newest scan of each robot, whatever its scans are for.
void AddNewestScans(const ServerLoad& load, RobotNames* names, Values* values) {
  std::map<std::string, int64_t> newest;
  for (const SessionLoad& session : load.sessions) {
    int64_t& at_ns = newest[names->NameOf(session.robot)];
    at_ns = std::max(at_ns, session.received_ns);
  }
  for (const RobotPlace& place : load.localising) {
    int64_t& at_ns = newest[names->NameOf(place.robot)];
    at_ns = std::max(at_ns, place.localising->received_ns);
  }
  for (const auto& [name, at_ns] : newest) {
    if (at_ns == 0) continue;
    values->Gauge("isthmus_robot_last_scan_timestamp_seconds",
                  "When the newest scan came, Unix time.", 1e-9 * static_cast<double>(at_ns),
                  {{"robot", name}});
  }
}

void AddRobots(const ServerLoad& load, RobotNames* names, Values* values) {
  std::map<std::string, RobotLag> robots;
  for (const SessionLoad& session : load.sessions) {
    RobotLag& robot = robots[names->NameOf(session.robot)];
    robot.unacknowledged += Minus(session.received_sequence, session.acknowledged_sequence);
    robot.undurable += Minus(session.received_sequence, session.durable_sequence);
    robot.lost += session.lost_since_ns != 0 ? 1 : 0;
    robot.ack_lag_s =
        std::max(robot.ack_lag_s, Since(session.oldest_unacknowledged_ns, load.now_ns));
    robot.durable_lag_s =
        std::max(robot.durable_lag_s, Since(session.oldest_undurable_ns, load.now_ns));
  }
  for (const auto& [name, robot] : robots) {
    values->Gauge("isthmus_robot_unacknowledged_scans",
                  "Scans that came and are not acknowledged yet.", robot.unacknowledged,
                  {{"robot", name}});
    values->Gauge("isthmus_robot_ack_lag_seconds",
                  "How long the oldest scan that is not acknowledged has waited.", robot.ack_lag_s,
                  {{"robot", name}});
    values->Gauge("isthmus_robot_undurable_scans",
                  "Scans that came and would be lost with the server.", robot.undurable,
                  {{"robot", name}});
    values->Gauge("isthmus_robot_durable_lag_seconds",
                  "How long ago the oldest scan came that would be lost with the server.",
                  robot.durable_lag_s, {{"robot", name}});
    values->Gauge("isthmus_robot_lost", "Open sessions whose odometry has lost its way.",
                  robot.lost, {{"robot", name}});
  }
}

void AddQueues(const ServerLoad& load, Values* values) {
  values->Gauge("isthmus_sessions_open", "Sessions that are not finished.", load.sessions.size());
  values->Gauge("isthmus_queue_scans", "Scans that wait for their odometry.", load.waiting_scans);
  values->Gauge("isthmus_queue_bytes", "Bytes of these and of the scans at work.",
                load.waiting_bytes);
  values->Gauge("isthmus_queue_limit_bytes", "Bytes at which robots are slowed down.",
                load.waiting_bytes_limit);
  values->Gauge("isthmus_uploads_in_progress", "Submaps that are being checked and stored.",
                load.submaps_coming_in);
  values->Gauge("isthmus_matching_waiting_submaps", "Submaps that wait to be looked for loops.",
                load.matching.submaps);
  values->Gauge("isthmus_matching_waiting_pairs", "Pairs of sessions that wait to be matched.",
                load.matching.pairs);
  values->Gauge("isthmus_matching_jobs", "Jobs that workers have, or are to take.",
                load.matching.jobs);
  values->Gauge("isthmus_matching_jobs_set_aside",
                "Jobs that workers, or the server, ended with time and again, which are left out.",
                load.matching.jobs_set_aside);
  values->Gauge("isthmus_matching_workers", "Processes that do jobs for the site.",
                load.matching.workers);
  values->Gauge("isthmus_placement_waiting", "1: the map has changed and is not placed anew yet.",
                load.placement_waits);
  values->Gauge("isthmus_composition_waiting", "1: the latest revision is not composed yet.",
                load.composition_waits);
}

void AddMap(const ServerLoad& load, const MapInfo& info, Values* values) {
  values->Gauge("isthmus_map_revision", "The latest revision of the map.",
                static_cast<double>(load.revision));
  values->Gauge("isthmus_map_components", "Pieces of the map that nothing joins yet.",
                info.components.size());
  values->Gauge("isthmus_map_robots", "Robots that the map knows.", info.robots.size());
  values->Gauge("isthmus_map_submaps", "Submaps in the latest revision.", load.submaps);
  values->Gauge("isthmus_map_loading", "1: after a start, no map has been composed yet.",
                load.map_is_loading);
  values->Gauge("isthmus_damaged_submaps", "Submaps that cannot be read and are left out.",
                info.damaged.size());
  values->Counter("isthmus_retired_submaps_total",
                  "Submaps that newer ones of the same ground took the place of.", info.retired);
  for (const MatchCount& count : load.matches) {
    values->Gauge("isthmus_matches", "Pairs of sessions by state and by what decided on them.",
                  count.matches,
                  {{"state", ToString(count.state)}, {"reason", ToString(count.reason)}});
  }
}

void AddCache(const char* name, const CacheLoad& cache, Values* values) {
  values->Gauge("isthmus_cache_bytes", "Points of the map that are kept in memory.", cache.bytes,
                {{"cache", name}});
  values->Gauge("isthmus_cache_limit_bytes", "Bytes that they may take.", cache.limit_bytes,
                {{"cache", name}});
}

void AddStorage(const ServerLoad& load, Values* values) {
  AddCache("submaps", load.submap_cache, values);
  AddCache("prepared", load.prepared_maps, values);
  AddCache("composed", load.composed, values);
  const DiskLoad& disk = load.disk;
  const auto used = [values](const char* kind, uint64_t bytes) {
    values->Gauge("isthmus_disk_used_bytes", "Bytes on the disk, by what they hold.", bytes,
                  {{"kind", kind}});
  };
  used("database", disk.database_bytes);
  used("log", disk.log_bytes);
  used("scans", disk.scan_bytes);
  used("spill", disk.spilled_bytes);
  values->Gauge("isthmus_disk_free_bytes", "Bytes that are free on the file system.",
                disk.free_bytes);
  values->Gauge("isthmus_disk_size_bytes", "Bytes that it has in all.", disk.total_bytes);
  values->Gauge("isthmus_storage_failing", "1: what comes in cannot be stored at the moment.",
                load.storage_problem.empty() ? 0 : 1);
  values->Gauge("isthmus_replica_behind_seconds",
                "Of a server that only reads: since it last had all that the store holds. Else 0.",
                load.replica ? load.replica->behind_s : 0);
}

}  // namespace

void AddSite(const std::string& site, server::Pipeline& pipeline, RobotNames* robots,
             Values* values) {
  const ServerLoad load = pipeline.GetLoad();
  const MapInfo info = pipeline.GetMapInfo();
  values->SetSite(site);
  AddRobots(load, robots, values);
  AddLocalising(load, robots, values);
  AddNewestScans(load, robots, values);
  AddQueues(load, values);
  AddMap(load, info, values);
  AddStorage(load, values);
  values->SetSite("");
}

}  // namespace isthmus::metrics
