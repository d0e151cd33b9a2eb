#include "lab/bench/merging/asked_table.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <array>

#include "lab/bench/merging/figures.h"

namespace isthmus::bench {
namespace {

constexpr size_t kOutcomes = 5;

const char* NameOf(AskedOutcome outcome) {
  switch (outcome) {
    case AskedOutcome::kRight:
      return "right";
    case AskedOutcome::kWrong:
      return "WRONG";
    case AskedOutcome::kRefuted:
      return "refuted";
    case AskedOutcome::kWaiting:
      return "waiting";
    case AskedOutcome::kLost:
      return "lost";
  }
  return "";
}

using Which = AskedState AskedStep::*;

// After so many drives, or after the last where there were fewer.
std::string Row(const std::vector<AskedTrial>& trials, size_t drives, bool by_itself, Which which) {
  std::array<int, kOutcomes> outcomes = {};
  std::vector<double> metres;
  int blocked = 0, right = 0;
  for (const AskedTrial& trial : trials) {
    if (trial.steps.empty()) continue;
    const size_t last = std::min(drives, trial.steps.size());
    const AskedState& state = trial.steps[last - 1].*which;
    ++outcomes[static_cast<size_t>(state.outcome)];
    right += state.hypothesis_right;
    double sum = 0;
    for (size_t i = 0; i < last; ++i) {
      sum += trial.steps[i].metres;
      blocked += trial.steps[i].blocked;
    }
    metres.push_back(sum);
  }
  std::string row = absl::StrFormat("| %s, %d |", by_itself ? "by itself" : "asked", drives);
  for (const int count : outcomes) absl::StrAppendFormat(&row, " %d |", count);
  return row + absl::StrFormat(" %d | %.0f (%.0f) | %s |\n", right, Median(metres), Worst(metres),
                               by_itself ? "–" : absl::StrCat(blocked));
}

std::string Drives(const std::vector<AskedTrial>& trials) {
  std::string table =
      "| after drives | right | WRONG | refuted | waiting | lost | best hypothesis right | metres "
      "(most) | blocked |\n|---|---|---|---|---|---|---|---|---|\n";
  for (const bool by_itself : {false, true}) {
    for (size_t drives = 1; drives <= kAskedDrives; ++drives) {
      table +=
          Row(trials, drives, by_itself, by_itself ? &AskedStep::wandering : &AskedStep::asked);
    }
  }
  return table;
}

// The confidences that single drives were to bring, and what they brought.
std::string Predictions(const std::vector<AskedTrial>& trials) {
  std::string table =
      "| hypothesis in question | drives | blocked | predicted | then, median | merged right | "
      "WRONG | refuted |\n|---|---|---|---|---|---|---|---|\n";
  for (const bool right : {true, false}) {
    std::vector<double> predicted, then;
    std::array<int, kOutcomes> outcomes = {};
    int blocked = 0;
    for (const AskedTrial& trial : trials) {
      for (const AskedStep& step : trial.steps) {
        if (step.right != right) continue;
        predicted.push_back(step.predicted);
        then.push_back(step.asked.confidence);
        blocked += step.blocked;
        ++outcomes[static_cast<size_t>(step.asked.outcome)];
      }
    }
    absl::StrAppendFormat(&table, "| %s | %d | %d | %.2f | %.2f | %d | %d | %d |\n",
                          right ? "right" : "wrong", predicted.size(), blocked, Median(predicted),
                          Median(then), outcomes[0], outcomes[1], outcomes[2]);
  }
  return table;
}

nlohmann::ordered_json ToJson(const AskedState& state) {
  return {{"outcome", NameOf(state.outcome)},
          {"state", ToString(state.state)},
          {"reason", ToString(state.reason)},
          {"confidence", state.confidence},
          {"hypothesis_right", state.hypothesis_right}};
}

std::string Words(const AskedState& state) {
  return absl::StrFormat("%s (%s %s, confidence %.2f, hypothesis %s)", NameOf(state.outcome),
                         ToString(state.state), ToString(state.reason), state.confidence,
                         state.hypothesis_right ? "right" : "wrong");
}

}  // namespace

std::string AskedLines(const AskedTrial& trial) {
  std::string lines = absl::StrFormat("%s %d %d~%d: overlap %.2f, %s", trial.scenario, trial.seed,
                                      trial.a, trial.b, trial.overlap, Words(trial.before));
  if (trial.Waits() && trial.steps.empty()) lines += ", nothing to ask";
  for (const AskedStep& step : trial.steps) {
    absl::StrAppendFormat(&lines,
                          "\n  robot %d, %.1f m of %.1f%s, %s place, predicted %.2f: %s; by "
                          "itself: %s",
                          step.robot == 0 ? trial.a : trial.b, step.metres, step.asked_m,
                          step.blocked ? " (blocked)" : "", step.right ? "right" : "wrong",
                          step.predicted, Words(step.asked), Words(step.wandering));
  }
  return lines;
}

std::string AskedTables(const std::vector<AskedTrial>& trials) {
  const auto count = [&](const auto& holds) { return std::ranges::count_if(trials, holds); };
  std::string table =
      "| pairs | merged before | WRONG before | waiting, with overlap | with the right place first "
      "| "
      "nothing to ask |\n|---|---|---|---|---|---|\n";
  const auto is = [](AskedOutcome outcome) {
    return [outcome](const AskedTrial& trial) { return trial.before.outcome == outcome; };
  };
  const auto waits = [](const AskedTrial& trial) { return trial.Waits(); };
  absl::StrAppendFormat(
      &table, "| %d | %d | %d | %d | %d | %d |\n\n", trials.size(), count(is(AskedOutcome::kRight)),
      count(is(AskedOutcome::kWrong)), count(waits),
      count([](const auto& trial) { return trial.Waits() && trial.before.hypothesis_right; }),
      count([](const auto& trial) { return trial.Waits() && trial.steps.empty(); }));
  return absl::StrCat(table, Drives(trials), "\n", Predictions(trials));
}

nlohmann::ordered_json ToJson(const AskedTrial& trial) {
  nlohmann::ordered_json json = {{"scenario", trial.scenario},
                                 {"seed", trial.seed},
                                 {"a", trial.a},
                                 {"b", trial.b},
                                 {"overlap_of_truth", trial.overlap},
                                 {"waits", trial.Waits()},
                                 {"before", ToJson(trial.before)},
                                 {"drives", nlohmann::ordered_json::array()}};
  for (const AskedStep& step : trial.steps) {
    json["drives"].push_back({{"robot", step.robot == 0 ? trial.a : trial.b},
                              {"asked_m", step.asked_m},
                              {"metres", step.metres},
                              {"blocked", step.blocked},
                              {"predicted", step.predicted},
                              {"right", step.right},
                              {"asked", ToJson(step.asked)},
                              {"by_itself", ToJson(step.wandering)}});
  }
  return json;
}

}  // namespace isthmus::bench
