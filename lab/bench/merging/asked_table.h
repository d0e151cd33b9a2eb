// The report of pairs in closed loop.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "lab/bench/merging/asked_trial.h"

namespace isthmus::bench {

// A line about the pair, and one about each drive, to watch progress.
std::string AskedLines(const AskedTrial& trial);

// Markdown: what became of the pairs before any drive; of those that waited and were asked after
// one, two, three drives, and after as many metres by themselves; and the confidences that the
// drives were to bring beside what they brought.
std::string AskedTables(const std::vector<AskedTrial>& trials);

// All figures, an entry per drive.
nlohmann::ordered_json ToJson(const AskedTrial& trial);

}  // namespace isthmus::bench
