#include "lab/bench/mapping/report.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

namespace isthmus::bench {
namespace {

using Json = nlohmann::ordered_json;

std::string Metres(const std::vector<double>& values) {
  return absl::StrJoin(values, ", ", [](std::string* out, double value) {
    absl::StrAppendFormat(out, "%.3f", value);
  });
}

std::string MapTable(const std::vector<MapTrial>& trials) {
  std::string table =
      "| map | seed | submaps | open loop RMSE m | submaps in the map m | ways in the map m | "
      "closures "
      "(edges) | false (edges) | false in use | closures' error m, deg (worst right) | revisions | "
      "CPU s | longest ms |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const MapTrial& t : trials) {
    absl::StrAppendFormat(
        &table,
        "| %s | %d | %d | %s | %s | %s | %d (%d) | %d (%d) | %d | %.3f, %.2f (%.3f, %.2f) | %d | "
        "%.1f | %.0f |\n",
        t.name, t.seed, t.submaps, Metres(t.open_m),
        t.one_frame ? Metres(t.map.robots_m) : "not one frame",
        t.one_frame ? Metres(t.trajectories.robots_m) : "–", t.loops.loops, t.loops.edges,
        t.loops.false_loops, t.loops.false_edges, t.loops.false_used, t.loops.median_m,
        t.loops.median_deg, t.loops.worst_m, t.loops.worst_deg, t.revisions, t.cpu_ms / 1e3,
        t.worst_upload_ms);
  }
  return table;
}

std::string FalseLoopsTable(const std::vector<FalseLoopsTrial>& trials) {
  std::string table =
      "| false closures | seed | edges | false | false kept | right lost | open loop RMSE m | "
      "without m | with m | ratio | ms without | ms with |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const FalseLoopsTrial& t : trials) {
    absl::StrAppendFormat(
        &table, "| %s | %d | %d | %d | %d | %d | %.3f | %.3f | %.3f | %.2f | %.0f | %.0f |\n",
        t.name, t.seed, t.edges, t.false_edges, t.false_kept, t.right_lost, t.open_m, t.without_m,
        t.with_m, t.with_m / t.without_m, t.without_ms, t.with_ms);
  }
  return table;
}

std::string LapsTable(const LapsTrial& trial) {
  std::string table =
      absl::StrFormat("%d submaps a lap of %.0f m\n\n", trial.submaps_per_lap, trial.lap_m);
  absl::StrAppend(&table, LapsHeader());
  for (const LapsRow& row : trial.rows) absl::StrAppend(&table, ToLine(row));
  return table;
}

std::string UndoTable(const std::vector<UndoTrial>& trials) {
  std::string table =
      "| undone by | seed | merged before | forced move m | left m | left deg |\n"
      "|---|---|---|---|---|---|\n";
  for (const UndoTrial& t : trials) {
    absl::StrAppendFormat(&table, "| %s | %d | %s | %.2f | %.6f | %.6f |\n", t.name, t.seed,
                          t.merged_before ? "yes" : "no", t.forced_m, t.left_m, t.left_deg);
  }
  return table;
}

std::string NextDayTable(const std::vector<NextDayTrial>& trials) {
  std::string table =
      "| seed | as before after restart | placed after submap | yesterday RMSE m | today RMSE m | "
      "today worst m |\n|---|---|---|---|---|---|\n";
  for (const NextDayTrial& t : trials) {
    const std::string placed =
        t.placed ? absl::StrCat(t.placed_after, " of ", t.submaps) : "not at all";
    absl::StrAppendFormat(&table, "| %d | %s | %s | %.3f | %.3f | %.3f |\n", t.seed,
                          t.same_after_restart ? "yes" : "NO", placed, t.yesterday_rmse_m,
                          t.today_rmse_m, t.today_worst_m);
  }
  return table;
}

Json ToJson(const MapTrial& t) {
  return {{"name", t.name},
          {"seed", t.seed},
          {"submaps", t.submaps},
          {"in_map", t.in_map},
          {"retired", t.retired},
          {"open_loop_rmse_m", t.open_m},
          {"one_frame", t.one_frame},
          {"submaps_rmse_m", t.map.all_m},
          {"submaps_rmse_of_robots_m", t.map.robots_m},
          {"trajectory_rmse_m", t.trajectories.all_m},
          {"sharpness", ToJson(t.sharpness)},
          {"trajectory_rmse_of_robots_m", t.trajectories.robots_m},
          {"loops", t.loops.loops},
          {"edges", t.loops.edges},
          {"false_loops", t.loops.false_loops},
          {"false_edges", t.loops.false_edges},
          {"false_used", t.loops.false_used},
          {"loop_error", {{"median_m", t.loops.median_m}, {"median_deg", t.loops.median_deg}}},
          {"worst_right_loop", {{"m", t.loops.worst_m}, {"deg", t.loops.worst_deg}}},
          {"matches", t.matches},
          {"revisions", t.revisions},
          {"cpu_ms", t.cpu_ms},
          {"worst_upload_ms", t.worst_upload_ms}};
}

Json ToJson(const FalseLoopsTrial& t) {
  return {{"kind", t.name},
          {"seed", t.seed},
          {"edges", t.edges},
          {"false_edges", t.false_edges},
          {"false_kept", t.false_kept},
          {"right_lost", t.right_lost},
          {"open_loop_rmse_m", t.open_m},
          {"without_rmse_m", t.without_m},
          {"with_rmse_m", t.with_m},
          {"without_cpu_ms", t.without_ms},
          {"with_cpu_ms", t.with_ms}};
}

Json ToJson(const LapsRow& row) {
  return {{"laps", row.laps},
          {"submaps", row.submaps},
          {"retired", row.retired},
          {"loops", row.loops},
          {"edges", row.edges},
          {"database_mb", row.database_mb},
          {"resident_mb", row.resident_mb},
          {"ms_per_lap", row.ms_per_lap},
          {"cpu_ms_per_lap", row.cpu_ms_per_lap},
          {"rmse_m", row.rmse_m}};
}

Json ToJson(const UndoTrial& t) {
  return {{"undone_by", t.name},    {"seed", t.seed},     {"merged_before", t.merged_before},
          {"forced_m", t.forced_m}, {"left_m", t.left_m}, {"left_deg", t.left_deg}};
}

Json ToJson(const NextDayTrial& t) {
  return {{"seed", t.seed},
          {"same_after_restart", t.same_after_restart},
          {"placed", t.placed},
          {"placed_after", t.placed_after},
          {"submaps", t.submaps},
          {"yesterday_rmse_m", t.yesterday_rmse_m},
          {"today_rmse_m", t.today_rmse_m},
          {"today_worst_m", t.today_worst_m}};
}

template <typename Trial>
Json ListOf(const std::vector<Trial>& trials) {
  Json list = Json::array();
  for (const Trial& trial : trials) list.push_back(ToJson(trial));
  return list;
}

}  // namespace

std::string LapsHeader() {
  return "| laps | submaps | retired | closures (edges) | database MB | RAM MB | ms a lap (CPU) | "
         "RMSE m |\n|---|---|---|---|---|---|---|---|\n";
}

std::string ToLine(const LapsRow& row) {
  return absl::StrFormat("| %d | %d | %d | %d (%d) | %.2f | %.0f | %.0f (%.0f) | %.3f |\n",
                         row.laps, row.submaps, row.retired, row.loops, row.edges, row.database_mb,
                         row.resident_mb, row.ms_per_lap, row.cpu_ms_per_lap, row.rmse_m);
}

std::string MappingTables(const MappingResults& results) {
  std::string text;
  if (!results.maps.empty()) absl::StrAppend(&text, MapTable(results.maps), "\n");
  std::vector<MapSharpness> maps;
  for (const MapTrial& t : results.maps) maps.push_back({t.name, t.seed, t.sharpness});
  if (!maps.empty()) absl::StrAppend(&text, SharpnessTable(maps), "\n");
  if (!results.false_loops.empty()) {
    absl::StrAppend(&text, FalseLoopsTable(results.false_loops), "\n");
  }
  if (!results.laps.rows.empty()) absl::StrAppend(&text, LapsTable(results.laps), "\n");
  if (!results.undo.empty()) absl::StrAppend(&text, UndoTable(results.undo), "\n");
  if (!results.next_days.empty()) absl::StrAppend(&text, NextDayTable(results.next_days), "\n");
  return text;
}

nlohmann::ordered_json ToJson(const MappingResults& results) {
  return {{"maps", ListOf(results.maps)},
          {"false_loops", ListOf(results.false_loops)},
          {"laps",
           {{"submaps_per_lap", results.laps.submaps_per_lap},
            {"lap_m", results.laps.lap_m},
            {"rows", ListOf(results.laps.rows)}}},
          {"undo", ListOf(results.undo)},
          {"next_day", ListOf(results.next_days)}};
}

}  // namespace isthmus::bench
