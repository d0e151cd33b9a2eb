#include "bench/merging/report.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <map>

namespace isthmus::bench {
namespace {

const char* Word(TrialOutcome outcome) {
  switch (outcome) {
    case TrialOutcome::kRight:
      return "right";
    case TrialOutcome::kNotMerged:
      return "not merged";
    case TrialOutcome::kWrong:
      return "WRONG";
  }
  return "";
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double MatchingMs(const Match& match) {
  double ms = 0;
  for (const StageTime& stage : match.stages) ms += stage.ms;
  return ms;
}

std::vector<double> Collect(const std::vector<Trial>& trials, bool right_only,
                            double (*value)(const Trial&)) {
  std::vector<double> values;
  for (const Trial& trial : trials) {
    if (!right_only || trial.outcome == TrialOutcome::kRight) values.push_back(value(trial));
  }
  return values;
}

// "AMBIGUOUS 1, NOT_YET 2": why pairs were not merged.
std::string Reasons(const std::vector<Trial>& trials) {
  std::map<std::string, int> counts;
  for (const Trial& trial : trials) {
    if (trial.outcome != TrialOutcome::kNotMerged) continue;
    ++counts[absl::StrCat(ToString(trial.match.state), " ", trial.match.reason)];
  }
  std::string text;
  for (const auto& [reason, count] : counts) {
    absl::StrAppend(&text, text.empty() ? "" : ", ", count, " ", reason);
  }
  return text.empty() ? "–" : text;
}

}  // namespace

std::string TrialLine(const std::string& scenario, const Trial& trial) {
  return absl::StrFormat(
      "%s %d: %s (%s %s), overlap %.2f, maps %.3f m %.2f deg, start frames %.3f m %.2f deg, "
      "odometry %.3f m, %d lost, %.0f ms",
      scenario, trial.seed, Word(trial.outcome), ToString(trial.match.state), trial.match.reason,
      trial.overlap, trial.map.median_m, trial.map.median_deg, trial.start_m, trial.start_deg,
      trial.odometry_m, trial.lost_scans, MatchingMs(trial.match));
}

std::string MergingTable(const std::vector<ScenarioTrials>& scenarios) {
  std::string table =
      "| scenario | pairs | overlap | right | WRONG | not merged | map on map m, deg (worst) | "
      "start frames m, deg | matching ms |\n|---|---|---|---|---|---|---|---|---|\n";
  for (const auto& [scenario, trials] : scenarios) {
    const auto count = [&t = trials](TrialOutcome outcome) {
      return std::count_if(t.begin(), t.end(),
                           [&](const Trial& x) { return x.outcome == outcome; });
    };
    const auto overlap = Collect(trials, false, [](const Trial& t) { return t.overlap; });
    const auto metres = Collect(trials, true, [](const Trial& t) { return t.map.median_m; });
    const auto degrees = Collect(trials, true, [](const Trial& t) { return t.map.median_deg; });
    const auto worst = [](const std::vector<double>& v) {
      return v.empty() ? 0 : *std::max_element(v.begin(), v.end());
    };
    absl::StrAppendFormat(
        &table,
        "| %s | %d | %.2f-%.2f | %d | %d | %s | %.3f, %.2f (%.3f, %.2f) | %.3f, %.2f | %.0f |\n",
        scenario, trials.size(), *std::min_element(overlap.begin(), overlap.end()), worst(overlap),
        count(TrialOutcome::kRight), count(TrialOutcome::kWrong), Reasons(trials), Median(metres),
        Median(degrees), worst(metres), worst(degrees),
        Median(Collect(trials, true, [](const Trial& t) { return t.start_m; })),
        Median(Collect(trials, true, [](const Trial& t) { return t.start_deg; })),
        Median(Collect(trials, false, [](const Trial& t) { return MatchingMs(t.match); })));
  }
  return table;
}

nlohmann::ordered_json ToJson(const ScenarioTrials& scenario) {
  nlohmann::ordered_json json = {{"scenario", scenario.scenario},
                                 {"trials", nlohmann::ordered_json::array()}};
  for (const Trial& trial : scenario.trials) {
    nlohmann::ordered_json entry = {{"seed", trial.seed},
                                    {"outcome", Word(trial.outcome)},
                                    {"state", ToString(trial.match.state)},
                                    {"reason", trial.match.reason},
                                    {"overlap", trial.overlap},
                                    {"map_m", trial.map.median_m},
                                    {"map_deg", trial.map.median_deg},
                                    {"start_m", trial.start_m},
                                    {"start_deg", trial.start_deg},
                                    {"odometry_rmse_m", trial.odometry_m},
                                    {"lost_scans", trial.lost_scans},
                                    {"free_space", trial.match.free_space},
                                    {"runner_up", trial.match.runner_up},
                                    {"comparisons", trial.match.comparisons},
                                    {"stages_ms", nlohmann::ordered_json::object()}};
    for (const StageTime& stage : trial.match.stages) entry["stages_ms"][stage.stage] = stage.ms;
    json["trials"].push_back(std::move(entry));
  }
  return json;
}

}  // namespace isthmus::bench
