#include "client/offline/bench_report.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace isthmus::cli {
namespace {

// The figures of one line of the table.
struct Row {
  std::string world, mode, seed;
  double mean_ms[2] = {}, max_ms[2] = {};
  uint64_t lost = 0;
  double own_rmse_m[2] = {};
  std::optional<double> all_rmse_m = std::nullopt;
  double estimation_s = 0, composition_ms = 0;
};

Row ToRow(const PaperBenchRun& run) {
  Row row{run.world, run.mode, absl::StrCat(run.seed)};
  for (size_t i = 0; i < run.robots.size() && i < 2; ++i) {
    row.mean_ms[i] = run.robots[i].mean_ms;
    row.max_ms[i] = run.robots[i].max_ms;
    row.lost += run.robots[i].lost;
    row.own_rmse_m[i] = run.robots[i].own.rmse_m;
  }
  if (run.all) row.all_rmse_m = run.all->rmse_m;
  row.estimation_s = run.estimation_ms / 1000;
  row.composition_ms = run.composition_max_ms;
  return row;
}

Row MeanOf(const std::vector<Row>& rows) {
  Row mean{rows[0].world, rows[0].mode, "mean"};
  const auto count = static_cast<double>(rows.size());
  double all = 0;
  bool merged = true;
  for (const Row& row : rows) {
    for (int i = 0; i < 2; ++i) {
      mean.mean_ms[i] += row.mean_ms[i] / count;
      mean.max_ms[i] = std::max(mean.max_ms[i], row.max_ms[i]);
      mean.own_rmse_m[i] += row.own_rmse_m[i] / count;
    }
    mean.lost += row.lost;
    merged = merged && row.all_rmse_m.has_value();
    all += row.all_rmse_m.value_or(0) / count;
    mean.estimation_s += row.estimation_s / count;
    mean.composition_ms += row.composition_ms / count;
  }
  if (merged) mean.all_rmse_m = all;
  return mean;
}

std::string Line(const Row& row) {
  return absl::StrFormat(
      "%-10s %-11s %5s %8.2f %7.1f %8.2f %7.1f %5d %9.4f %9.4f %10s %9.1f %9.1f\n", row.world,
      row.mode, row.seed, row.mean_ms[0], row.max_ms[0], row.mean_ms[1], row.max_ms[1], row.lost,
      row.own_rmse_m[0], row.own_rmse_m[1],
      row.all_rmse_m ? absl::StrFormat("%.4f", *row.all_rmse_m) : "not merged", row.estimation_s,
      row.composition_ms);
}

Json ToJson(const evaluation::ErrorStatistics& errors) {
  return {{"poses", errors.count},   {"rmse_m", errors.rmse_m},
          {"mean_m", errors.mean_m}, {"median_m", errors.median_m},
          {"max_m", errors.max_m},   {"rotation_rmse_deg", errors.rotation_rmse_deg}};
}

Json ToJson(const PaperBenchRun& run) {
  Json out = {{"world", run.world},
              {"odometry", run.mode},
              {"seed", run.seed},
              {"robots", Json::array()},
              {"merged", run.all ? ToJson(*run.all) : Json(nullptr)},
              {"estimation_ms", run.estimation_ms},
              {"composition_ms", run.composition_ms},
              {"composition_max_ms", run.composition_max_ms}};
  for (const PaperBenchRobot& robot : run.robots) {
    out["robots"].push_back({{"name", robot.name},
                             {"travelled_m", robot.travelled_m},
                             {"scans", robot.scans},
                             {"lost", robot.lost},
                             {"odometry_ms_mean", robot.mean_ms},
                             {"odometry_ms_max", robot.max_ms},
                             {"own", ToJson(robot.own)},
                             {"in_map", run.all ? ToJson(robot.in_map) : Json(nullptr)}});
  }
  return out;
}

}  // namespace

std::string PaperBenchHeader() {
  return absl::StrFormat(
      "%-10s %-11s %5s %16s %16s %5s %19s %10s %9s %9s\n%-10s %-11s %5s %8s %7s %8s %7s %5s %9s "
      "%9s %10s %9s %9s\n",
      "", "", "", "robot_0, ms/scan", "robot_1, ms/scan", "", "RMSE by itself, m", "RMSE, m",
      "estimate", "compose", "world", "odometry", "seed", "mean", "max", "mean", "max", "lost",
      "robot_0", "robot_1", "in one map", "s", "ms, max");
}

std::string PaperBenchLine(const PaperBenchRun& run) { return Line(ToRow(run)); }

std::string PaperBenchMeans(const std::vector<PaperBenchRun>& runs) {
  std::vector<std::vector<Row>> groups;  // By world and mode, in order of appearance.
  for (const PaperBenchRun& run : runs) {
    const Row row = ToRow(run);
    const auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& rows) {
      return rows[0].world == row.world && rows[0].mode == row.mode;
    });
    if (group == groups.end()) {
      groups.push_back({row});
    } else {
      group->push_back(row);
    }
  }
  std::string means;
  for (const std::vector<Row>& rows : groups) {
    if (rows.size() > 1) means += Line(MeanOf(rows));
  }
  return means;
}

Json ToJson(const PaperBenchOptions& options, const std::vector<PaperBenchRun>& runs) {
  Json out = {{"seconds", options.seconds}, {"runs", Json::array()}};
  for (const PaperBenchRun& run : runs) out["runs"].push_back(ToJson(run));
  return out;
}

}  // namespace isthmus::cli
