#include "client/console/json.h"

#include <iostream>

#include "client/console/localising_text.h"
#include "client/console/server_figures.h"

namespace isthmus::cli {
namespace {

template <typename Ids>
Json Names(const Ids& ids) {
  Json out = Json::array();
  for (const auto& id : ids) out.push_back(id.value());
  return out;
}

// Numbers that a stage did not compute are -1 in the API and null here, as is NaN.
template <typename T>
Json OrNull(T value) {
  return value >= 0 ? Json(value) : Json(nullptr);
}

}  // namespace

Json ToJson(const Pose& pose) {
  const Eigen::Vector3d& t = pose.translation();
  const Eigen::Quaterniond& q = pose.rotation();
  return {{"translation", {t.x(), t.y(), t.z()}}, {"rotation", {q.x(), q.y(), q.z(), q.w()}}};
}

Json ToJson(const Box& box) {
  if (box.empty()) return nullptr;
  return {{"min", {box.min.x(), box.min.y(), box.min.z()}},
          {"max", {box.max.x(), box.max.y(), box.max.z()}}};
}

Json ToJson(const SubmapEdge& edge) {
  Json information = Json::array();
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column)
      information.push_back(edge.information(row, column));
  }
  return {{"submap_a", edge.submap_a},
          {"submap_b", edge.submap_b},
          {"T_a_b", ToJson(edge.T_a_b)},
          {"information", std::move(information)}};
}

Json ToJson(const ScanCounts& scans) {
  return {{"ok", scans.ok},
          {"degenerate", scans.degenerate},
          {"lost", scans.lost},
          {"rejected", scans.rejected},
          {"skipped", scans.skipped}};
}

Json ToJson(const SessionStatus& session) {
  Json out = {
      {"session", session.record.id.value()},
      {"robot", session.record.robot.value()},
      {"sensor", session.record.sensor},
      {"odometry", session.record.odometry ? ToString(*session.record.odometry) : ""},
      {"when_behind",
       session.record.when_behind == WhenBehind::kKeepNewest ? "keep-newest" : "wait"},
      {"input", session.input},
      {"state", session.record.state == SessionState::kFinished ? "FINISHED" : "ACTIVE"},
      {"last_sequence", session.last_sequence},
      {"durable_sequence", session.durable_sequence},
      {"scans_processed", session.scans_processed},
      {"scans_rejected", session.scans_rejected},
      {"submap_count", session.submap_count},
      {"point_count", session.point_count},
      {"odometry_ms_mean", session.scans_processed == 0 ? Json() : Json(session.odometry_ms_mean)},
      {"travelled_m", session.travelled_m},
      {"tracking", ToString(session.tracking)},
      {"map_bytes", session.map_bytes},
      {"scan_bytes", session.scan_bytes},
      {"quota_bytes", session.quota_bytes},
      {"archive_problem", session.archive_problem},
      {"segment", session.record.segment},
      {"segments", session.segments},
      {"scans", ToJson(session.scans)},
      {"lost_since_ns", session.lost_since_ns},
  };
  const std::string& first = session.record.first_segment.value();
  out["first_segment"] = first.empty() ? Json(nullptr) : Json(first);
  out["component"] = session.component ? Json(*session.component) : Json(nullptr);
  out["T_map_odom"] = session.T_map_odom ? ToJson(*session.T_map_odom) : Json(nullptr);
  return out;
}

namespace {

Json ToJson(const SessionLoad& load, int64_t now_ns) {
  const Lag ack = AckLag(load, now_ns), durable = DurableLag(load, now_ns);
  const auto seconds = [](const Lag& lag) { return lag.seconds < 0 ? Json() : Json(lag.seconds); };
  return {{"session", load.session.value()},
          {"robot", load.robot.value()},
          {"tracking", ToString(load.tracking)},
          {"lost_since_ns", load.lost_since_ns},
          {"waiting_scans", load.waiting_scans},
          {"waiting_bytes", load.waiting_bytes},
          {"received_sequence", load.received_sequence},
          {"acknowledged_sequence", load.acknowledged_sequence},
          {"durable_sequence", load.durable_sequence},
          {"received_ns", load.received_ns},
          {"ack_delay_s", 1e-9 * static_cast<double>(load.ack_delay_ns)},
          {"unacknowledged_scans", ack.scans},
          {"unacknowledged_s", seconds(ack)},
          {"undurable_scans", durable.scans},
          {"undurable_s", seconds(durable)},
          {"scans_processed", load.scans_processed},
          {"scans_rejected", load.scans_rejected},
          {"scans_skipped", load.scans_skipped},
          {"submaps", load.submaps},
          {"map_bytes", load.map_bytes},
          {"scan_bytes", load.scan_bytes}};
}

Json ToJson(const std::optional<ReplicaState>& replica) {
  if (!replica) return nullptr;
  return {
      {"owner", replica->owner}, {"behind_s", replica->behind_s}, {"problem", replica->problem}};
}

Json ToJson(const CacheLoad& cache) {
  return {{"bytes", cache.bytes}, {"limit_bytes", cache.limit_bytes}};
}

Json ToJson(const DiskLoad& disk) {
  return {{"used_bytes", disk.used_bytes()},     {"database_bytes", disk.database_bytes},
          {"log_bytes", disk.log_bytes},         {"scan_bytes", disk.scan_bytes},
          {"spilled_bytes", disk.spilled_bytes}, {"free_bytes", disk.free_bytes},
          {"total_bytes", disk.total_bytes}};
}

Json ProcessJson(const ServerStatus& status) {
  const ProcessUse& process = status.process;
  const RunningCallCounts& calls = status.calls;
  return {{"cpu_s", process.cpu_s},
          {"resident_bytes", process.resident_bytes},
          {"threads", process.threads},
          {"open_files", process.open_files},
          {"open_files_limit", process.open_files_limit},
          {"calls",
           {{"streams", calls.streams},
            {"queries", calls.queries},
            {"exports", calls.exports},
            {"lists", calls.lists},
            {"others", calls.others}}}};
}

}  // namespace

Json ToJson(const ServerStatus& status) {
  const ServerLoad& load = status.load;
  Json out = {{"version", status.version},
              {"site", status.site},
              {"started_ns", status.started_ns},
              {"uptime_s", status.uptime_s},
              {"now_ns", load.now_ns},
              {"process", ProcessJson(status)},
              {"disk", ToJson(load.disk)},
              {"degraded", Json::array()},
              {"sessions", Json::array()},
              {"localising", Json::array()},
              {"queues",
               {{"scans", load.waiting_scans},
                {"bytes", load.waiting_bytes},
                {"bytes_limit", load.waiting_bytes_limit},
                {"session_scans_limit", load.session_scans_limit},
                {"session_bytes_limit", load.session_bytes_limit}}},
              {"matching",
               {{"idle", load.matching.is_idle},
                {"submaps", load.matching.submaps},
                {"pairs", load.matching.pairs},
                {"workers", load.matching.workers},
                {"jobs", load.matching.jobs},
                {"jobs_set_aside", load.matching.jobs_set_aside}}},
              {"placement_waits", load.placement_waits},
              {"composition_waits", load.composition_waits},
              {"map_is_loading", load.map_is_loading},
              {"submap_cache", ToJson(load.submap_cache)},
              {"prepared_maps", ToJson(load.prepared_maps)},
              {"composed", ToJson(load.composed)},
              {"uploads", status.uploads},
              {"submaps_coming_in", load.submaps_coming_in},
              {"web_address", status.web_address},
              {"replica", ToJson(load.replica)}};
  for (const DegradedService& one : status.degraded) {
    out["degraded"].push_back({{"service", one.service}, {"why", one.why}});
  }
  for (const SessionLoad& session : load.sessions) {
    out["sessions"].push_back(ToJson(session, load.now_ns));
  }
  for (const RobotPlace& place : load.localising) out["localising"].push_back(ToJson(place));
  return out;
}

Json ToJson(const MapInfo& info) {
  Json out = {{"revision", info.revision},
              {"settled", info.settled},
              {"robots", Names(info.robots)},
              {"components", Json::array()},
              {"composition_ms", info.composition_ms},
              {"composition_max_ms", info.composition_max_ms},
              {"estimation_ms", info.estimation_ms},
              {"placement_ms", info.placement_ms},
              {"compositions", info.compositions},
              {"estimations", info.estimations},
              {"placements", info.placements},
              {"submaps", info.submaps},
              {"retired", info.retired},
              {"damaged", info.damaged},
              {"storage_problem", info.storage_problem},
              {"replica", ToJson(info.replica)}};
  for (const Component& component : info.components) {
    out["components"].push_back({{"component", component.component},
                                 {"reference_session", component.reference.value()},
                                 {"sessions", Names(component.sessions)},
                                 {"robots", Names(component.robots)},
                                 {"point_count", component.point_count},
                                 {"bounds", ToJson(component.bounds)}});
  }
  return out;
}

Json ToJson(const MatchEdge& edge, bool with_edges) {
  const Match& match = edge.match;
  Json out = {{"session_a", match.a.value()},
              {"session_b", match.b.value()},
              {"robot_a", edge.robot_a.value()},
              {"robot_b", edge.robot_b.value()},
              {"state", ToString(match.state)},
              {"reason", ToString(match.reason)},
              {"detail", match.detail},
              {"in_tree", edge.in_tree},
              {"T_a_b", ToJson(match.T_a_b)},
              {"confidence", OrNull(match.confidence)},
              {"overlap", OrNull(match.overlap)},
              {"inliers", OrNull(match.inliers)},
              {"inlier_ratio", OrNull(match.inlier_ratio)},
              {"residual_m", OrNull(match.residual_m)},
              {"free_space", OrNull(match.free_space)},
              {"comparisons", OrNull(match.comparisons)},
              {"runner_up", OrNull(match.runner_up)},
              {"shared_area_m2", OrNull(match.shared_area_m2)},
              {"observability", OrNull(match.observability)},
              {"odometry_residual", OrNull(match.odometry_residual)},
              {"cycle_m", OrNull(match.cycle_m)},
              {"cycle_deg", OrNull(match.cycle_deg)},
              {"candidates", match.candidates},
              {"matcher", ToString(match.matcher)},
              {"submaps_a", match.submaps_a},
              {"submaps_b", match.submaps_b},
              {"computed_ns", match.computed_ns},
              {"stages_ms", Json::object()}};
  for (const StageTime& stage : match.stages) out["stages_ms"][stage.stage] = stage.ms;
  out["manual_decision"] = nullptr;
  if (edge.manual_decision) {
    out["manual_decision"] = {{"kind", ToString(edge.manual_decision->kind)},
                              {"note", edge.manual_decision->note},
                              {"given_ns", edge.manual_decision->given_ns}};
  }
  if (with_edges) {
    out["edges"] = Json::array();
    for (const SubmapEdge& submaps : match.edges) out["edges"].push_back(ToJson(submaps));
  }
  return out;
}

Json ToJson(const MatchGraph& graph, bool with_edges) {
  Json out = {
      {"revision", graph.revision}, {"matches", Json::array()}, {"placements", Json::array()}};
  for (const MatchEdge& edge : graph.matches) out["matches"].push_back(ToJson(edge, with_edges));
  for (const PlacedSession& placed : graph.placements) {
    out["placements"].push_back({{"session", placed.placement.session.value()},
                                 {"robot", placed.robot.value()},
                                 {"component", placed.placement.component},
                                 {"reference_session", placed.placement.reference.value()},
                                 {"T_map_odom", ToJson(placed.placement.T_map_odom)}});
  }
  return out;
}

Json Versioned(const Json& document) {
  Json out = {{"version", kJsonVersion}};
  out.update(document);
  return out;
}

namespace {

// Names and notes come from others: what is not UTF-8 is replaced rather than refused, and ASCII
// alone has nothing that a terminal obeys.
std::string Dump(const Json& document, int indent) {
  return Versioned(document).dump(indent, ' ', true, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string Text(const Json& document) { return Dump(document, 2); }

void Print(const Json& document) { std::cout << Text(document); }
void PrintLine(const Json& document) { std::cout << Dump(document, -1); }

}  // namespace isthmus::cli
