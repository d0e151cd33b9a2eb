#include "lab/commands/paper_tables.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <functional>
#include <string>

namespace isthmus::cli {
namespace {

using Runs = std::vector<const PaperBenchRun*>;
using Quantity = std::function<double(const PaperBenchRun&)>;

// As the paper calls the server with that odometry.
std::string NameOfMode(const std::string& mode) {
  if (mode == "floam") return "MR-FLOAM";
  if (mode == "aloam") return "MR-ALOAM";
  return mode == "continuous" ? "ours" : mode;
}

// In the order of `known`, the others after them as they come.
std::vector<std::string> Distinct(const std::vector<PaperBenchRun>& runs,
                                  std::string PaperBenchRun::*key,
                                  const std::vector<std::string>& known = {}) {
  std::vector<std::string> out;
  for (const std::string& name : known) {
    if (std::ranges::find(runs, name, key) != runs.end()) out.push_back(name);
  }
  for (const PaperBenchRun& run : runs) {
    if (std::ranges::find(out, run.*key) == out.end()) out.push_back(run.*key);
  }
  return out;
}

// A table in the making: a cell per world, quantity and odometry.
class PaperTable {
 public:
  PaperTable(const std::string& title, const std::vector<PaperBenchRun>& runs)
      : runs_(runs),
        worlds_(Distinct(runs, &PaperBenchRun::world)),
        modes_(Distinct(runs, &PaperBenchRun::mode, {"floam", "aloam", "continuous"})) {
    table_ = {title, {"world", ""}, {}, 2};
    for (const std::string& mode : modes_) table_.columns.push_back(NameOfMode(mode));
  }

  const std::vector<std::string>& worlds() const { return worlds_; }

  void AddRow(const std::string& world, const std::string& quantity,
              const std::function<std::string(const Runs&)>& cell) {
    std::vector<std::string> row = {world, quantity};
    for (const std::string& mode : modes_) {
      Runs runs;
      for (const PaperBenchRun& run : runs_) {
        if (run.world == world && run.mode == mode) runs.push_back(&run);
      }
      row.push_back(runs.empty() ? "" : cell(runs));
    }
    table_.rows.push_back(std::move(row));
  }

  void AddMean(const std::string& world, const std::string& quantity, int decimals,
               const Quantity& value) {
    AddRow(world, quantity, [&](const Runs& runs) {
      double sum = 0;
      for (const PaperBenchRun* run : runs) sum += value(*run);
      return absl::StrFormat("%.*f", decimals, sum / static_cast<double>(runs.size()));
    });
  }

  void AddLargest(const std::string& world, const std::string& quantity, const Quantity& value) {
    AddRow(world, quantity, [&](const Runs& runs) {
      double largest = 0;
      for (const PaperBenchRun* run : runs) largest = std::max(largest, value(*run));
      return absl::StrFormat("%.1f", largest);
    });
  }

  report::Table Take(const std::string& note) {
    table_.note = note;
    return std::move(table_);
  }

 private:
  const std::vector<PaperBenchRun>& runs_;
  std::vector<std::string> worlds_, modes_;
  report::Table table_;
};

std::string MergedRmse(const Runs& runs) {
  double sum = 0;
  for (const PaperBenchRun* run : runs) {
    if (!run->all) return "not merged";
    sum += run->all->rmse_m;
  }
  return absl::StrFormat("%.4f", sum / static_cast<double>(runs.size()));
}

report::Table ErrorTable(const std::vector<PaperBenchRun>& runs) {
  PaperTable table("Table 3. RMSE of the trajectories (eq. 3), m", runs);
  for (const std::string& world : table.worlds()) {
    for (size_t i = 0; i < runs.front().robots.size(); ++i) {
      table.AddMean(world, absl::StrCat("robot ", i + 1), 4,
                    [i](const PaperBenchRun& run) { return run.robots[i].own.rmse_m; });
    }
    table.AddRow(world, "both in one map", MergedRmse);
    table.AddRow(world, "lost scans", [](const Runs& of_mode) {
      uint64_t lost = 0;
      for (const PaperBenchRun* run : of_mode) {
        for (const PaperBenchRobot& robot : run->robots) lost += robot.lost;
      }
      return absl::StrCat(lost);
    });
  }
  return table.Take(
      "Robots aligned by themselves, then both by one alignment. Published, on other drives: "
      "museum "
      "0.96 m and 0.71 m.");
}

report::Table TimeTable(const std::vector<PaperBenchRun>& runs) {
  PaperTable table("Table 4. Run time", runs);
  for (const std::string& world : table.worlds()) {
    for (size_t i = 0; i < runs.front().robots.size(); ++i) {
      const std::string robot = absl::StrCat("robot ", i + 1, ", odometry per scan, ");
      table.AddMean(world, robot + "mean ms", 2,
                    [i](const PaperBenchRun& run) { return run.robots[i].mean_ms; });
      table.AddLargest(world, robot + "max ms",
                       [i](const PaperBenchRun& run) { return run.robots[i].max_ms; });
    }
    table.AddMean(world, "global map: transform between the robots, s", 3,
                  [](const PaperBenchRun& run) { return run.estimation_ms / 1000; });
    table.AddLargest(world, "global map: composition, max ms",
                     [](const PaperBenchRun& run) { return run.composition_max_ms; });
  }
  return table.Take(
      "Wall time. Published, on other drives and another computer: global map of the museum 0.296 "
      "s, outdoors 18.4 s (MR-FLOAM) and 53.8 s (MR-ALOAM).");
}

double StageMs(const PaperBenchRun& run, const std::string& stage) {
  const auto found = std::ranges::find(run.stages, stage, &StageTime::stage);
  return found == run.stages.end() ? 0 : found->ms;
}

double MeanOfRobots(const PaperBenchRun& run, double PaperBenchRobot::*ms) {
  double sum = 0;
  for (const PaperBenchRobot& robot : run.robots) sum += robot.*ms;
  return sum / static_cast<double>(run.robots.size());
}

report::Table StageTable(const std::vector<PaperBenchRun>& runs) {
  PaperTable table("Table 5. Run time of the stages, ms", runs);
  std::vector<std::string> stages;
  for (const PaperBenchRun& run : runs) {
    for (const StageTime& stage : run.stages) {
      if (std::ranges::find(stages, stage.stage) == stages.end()) stages.push_back(stage.stage);
    }
  }
  const std::pair<const char*, double PaperBenchRobot::*> odometry[] = {
      {"odometry: features", &PaperBenchRobot::features_ms},
      {"odometry: matching", &PaperBenchRobot::matching_ms},
      {"odometry: local map", &PaperBenchRobot::map_ms}};
  for (const std::string& world : table.worlds()) {
    for (const auto& [name, column] : odometry) {
      const auto ms = column;
      table.AddMean(world, name, 2,
                    [ms](const PaperBenchRun& run) { return MeanOfRobots(run, ms); });
    }
    for (const std::string& stage : stages) {
      table.AddMean(world, "global map: " + stage, 1,
                    [&stage](const PaperBenchRun& run) { return StageMs(run, stage); });
    }
    table.AddMean(world, "global map: composition", 1,
                  [](const PaperBenchRun& run) { return run.composition_ms; });
  }
  return table.Take("Odometry per scan, both robots; global map once, the last time.");
}

}  // namespace

std::vector<report::Table> PaperTables(const std::vector<PaperBenchRun>& runs) {
  if (runs.empty()) return {};
  return {ErrorTable(runs), TimeTable(runs), StageTable(runs)};
}

}  // namespace isthmus::cli
