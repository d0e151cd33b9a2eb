// isthmus bench: comparisons that others can repeat.
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/console/console.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/numbers.h"
#include "client/console/offline_commands.h"
#include "client/console/say.h"
#include "client/report/error_json.h"
#include "core/io/file_io.h"
#include "lab/commands/bench_paper.h"
#include "lab/commands/commands.h"
#include "lab/commands/paper_tables.h"

namespace isthmus::cli {
namespace {

// The figures of one line of the table.
struct TableRow {
  std::string world, mode, seed;
  double mean_ms[2] = {}, max_ms[2] = {};
  uint64_t lost = 0;
  double own_rmse_m[2] = {};
  std::optional<double> all_rmse_m = std::nullopt;
  double estimation_s = 0, composition_ms = 0;
};

TableRow ToRow(const PaperBenchRun& run) {
  TableRow row{run.world, run.mode, absl::StrCat(run.seed)};
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

TableRow MeanOf(const std::vector<TableRow>& rows) {
  TableRow mean{rows[0].world, rows[0].mode, "mean"};
  const auto count = static_cast<double>(rows.size());
  double all = 0;
  bool merged = true;
  for (const TableRow& row : rows) {
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

std::string Line(const TableRow& row) {
  return absl::StrFormat(
      "%-10s %-11s %5s %8.2f %7.1f %8.2f %7.1f %5d %9.4f %9.4f %10s %9.1f %9.1f\n", row.world,
      row.mode, row.seed, row.mean_ms[0], row.max_ms[0], row.mean_ms[1], row.max_ms[1], row.lost,
      row.own_rmse_m[0], row.own_rmse_m[1],
      row.all_rmse_m ? absl::StrFormat("%.4f", *row.all_rmse_m) : "not merged", row.estimation_s,
      row.composition_ms);
}

Json ToJson(const PaperBenchRun& run) {
  Json out = {{"world", run.world},
              {"odometry", run.mode},
              {"seed", run.seed},
              {"robots", Json::array()},
              {"merged", run.all ? cli::ToJson(*run.all) : Json(nullptr)},
              {"estimation_ms", run.estimation_ms},
              {"stages_ms", Json::object()},
              {"composition_ms", run.composition_ms},
              {"composition_max_ms", run.composition_max_ms}};
  for (const StageTime& stage : run.stages) out["stages_ms"][stage.stage] = stage.ms;
  for (const PaperBenchRobot& robot : run.robots) {
    out["robots"].push_back({{"name", robot.name},
                             {"travelled_m", robot.travelled_m},
                             {"scans", robot.scans},
                             {"lost", robot.lost},
                             {"odometry_ms_mean", robot.mean_ms},
                             {"odometry_ms_max", robot.max_ms},
                             {"features_ms", robot.features_ms},
                             {"matching_ms", robot.matching_ms},
                             {"map_ms", robot.map_ms},
                             {"own", cli::ToJson(robot.own)},
                             {"in_map", run.all ? cli::ToJson(robot.in_map) : Json(nullptr)}});
  }
  return out;
}

// A table, line by line as the runs come in.
std::string PaperBenchHeader() {
  return absl::StrFormat(
      "%-10s %-11s %5s %16s %16s %5s %19s %10s %9s %9s\n%-10s %-11s %5s %8s %7s %8s %7s %5s %9s "
      "%9s %10s %9s %9s\n",
      "", "", "", "robot_0, ms/scan", "robot_1, ms/scan", "", "RMSE by itself, m", "RMSE, m",
      "estimate", "compose", "world", "odometry", "seed", "mean", "max", "mean", "max", "lost",
      "robot_0", "robot_1", "in one map", "s", "ms, max");
}

std::string PaperBenchLine(const PaperBenchRun& run) { return Line(ToRow(run)); }

// A line per world and mode that has several seeds, with the means; of the maxima the largest, of
// the lost scans the sum, and an RMSE in one map only if all were merged.
std::string PaperBenchMeans(const std::vector<PaperBenchRun>& runs) {
  std::vector<std::vector<TableRow>> groups;  // By world and mode, in order of appearance.
  for (const PaperBenchRun& run : runs) {
    const TableRow row = ToRow(run);
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
  for (const std::vector<TableRow>& rows : groups) {
    if (rows.size() > 1) means += Line(MeanOf(rows));
  }
  return means;
}

Json ToJson(const PaperBenchOptions& options, const std::vector<PaperBenchRun>& runs) {
  Json out = {{"seconds", options.seconds}, {"runs", Json::array()}};
  for (const PaperBenchRun& run : runs) out["runs"].push_back(ToJson(run));
  return out;
}

struct BenchOptions {
  PaperBenchOptions bench;
  std::string format = "text", report;
};

absl::StatusOr<PaperBenchRun> RunWithProgress(const PaperBenchOptions& options,
                                              const std::string& world, const std::string& mode,
                                              uint64_t seed) {
  std::optional<Progress> progress;
  return RunPaperBench(world, mode, seed, options.seconds, [&](int done, int total) {
    if (!progress) progress.emplace(absl::StrCat(world, " ", seed, " ", mode), total);
    progress->Update(done);
  });
}

// Prints what is known as it comes: a bench takes minutes. Beside another format, which is to be a
// document by itself, to stderr.
void PrintLines(const std::string& lines, const BenchOptions& options) {
  std::FILE* out = options.format == "text" ? stdout : stderr;
  std::fputs(lines.c_str(), out);
  std::fflush(out);
}

int PrintResults(const std::vector<PaperBenchRun>& runs, const BenchOptions& options) {
  const Json everything = ToJson(options.bench, runs);
  if (options.format == "json") {
    Print(everything);
  } else {
    for (const report::Table& table : PaperTables(runs)) {
      SayLines("\n" + report::Format(table, report::ParseTableFormat(options.format)));
    }
  }
  if (options.report.empty()) return kOk;
  const absl::Status written = io::WriteFile(options.report, Text(everything));
  return written.ok() ? kOk : Fail(kFailed, written);
}

int Run(const BenchOptions& options) {
  const PaperBenchOptions& bench = options.bench;
  std::vector<PaperBenchRun> runs;
  for (const std::string& world : bench.worlds) {
    for (const uint64_t seed : bench.seeds) {
      for (const std::string& mode : bench.modes) {
        auto run = RunWithProgress(bench, world, mode, seed);
        if (absl::IsInvalidArgument(run.status())) return Fail(kUsage, run.status());
        if (!run.ok()) return Fail(kFailed, run.status());
        PrintLines((runs.empty() ? PaperBenchHeader() : "") + PaperBenchLine(*run), options);
        runs.push_back(*std::move(run));
      }
    }
  }
  PrintLines(PaperBenchMeans(runs), options);
  return PrintResults(runs, options);
}

}  // namespace

void AddBench(CLI::App& app, Action& action) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* bench = AddOfflineCommand(app, "bench");
  bench->require_subcommand(1);
  CLI::App* paper =
      bench->add_subcommand("paper", "Tables 3 to 5 of the paper: two robots, several odometries");
  paper->add_option("--worlds", options->bench.worlds, "museum, campus, ... (see simulate)")
      ->delimiter(',')
      ->capture_default_str();
  paper->add_option("--odometry", options->bench.modes, "aloam, floam, continuous")
      ->delimiter(',')
      ->capture_default_str();
  paper
      ->add_option("--seed", options->bench.seeds,
                   "Seeds of worlds, drives and noise, one or several")
      ->delimiter(',')
      ->check(NotNegative())
      ->capture_default_str();
  paper->add_option("--seconds", options->bench.seconds, "Length of each drive")
      ->check(Positive())
      ->capture_default_str();
  paper->add_option("--format", options->format, "Format of the tables")
      ->check(CLI::IsMember({"text", "markdown", "latex", "json"}))
      ->capture_default_str();
  paper->add_flag_callback(
      "--json", [format = &options->format] { *format = "json"; }, "As --format json");
  paper->add_option("--report", options->report, "REPORT.json for all results");
  paper->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
