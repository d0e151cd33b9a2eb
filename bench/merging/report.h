// What a merging benchmark prints.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/merging/trial.h"

namespace isthmus::bench {

struct ScenarioTrials {
  std::string scenario;
  std::vector<Trial> trials;
};

// One line about a trial, to watch progress.
std::string TrialLine(const std::string& scenario, const Trial& trial);
// A Markdown table with a row per scenario: counts, medians and worst errors of those right, and
// medians of what matching took, stage by stage.
std::string MergingTable(const std::vector<ScenarioTrials>& scenarios);
nlohmann::ordered_json ToJson(const ScenarioTrials& scenario);

}  // namespace isthmus::bench
