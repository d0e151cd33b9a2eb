// Summaries for programs and for people.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "lab/bench/summary.h"

namespace isthmus::bench {

// One drive that was run.
struct Entry {
  std::string scenario, mode, sensor;
  uint64_t seed = 0;
  size_t scans = 0;
  Summary summary;
};

// Costs in ms and cal; absent figures are null. Keys are described in lab/docs/odometry.md.
nlohmann::ordered_json ToJson(const Entry& entry);

// A Markdown table with a row per scenario: medians over its seeds of what it costs, the worst seed
// of every error, sums of counts. Below it tables of corridors and laps, if there are any.
std::string ToMarkdown(const std::vector<Entry>& entries);

// One line about an entry, to watch progress.
std::string ToLine(const Entry& entry);

}  // namespace isthmus::bench
