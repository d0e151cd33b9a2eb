// The report of a merging benchmark.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "lab/bench/merging/trial.h"

namespace isthmus::bench {

// A line about each pair of a trial, to watch progress.
std::string TrialLines(const Trial& trial);

// Markdown, a row per scenario: counts, why pairs were not merged, medians and worst errors of
// those that are right, and what matching took.
std::string MergingTable(const std::vector<Trial>& trials);

// The same, a row per world of the first robot and bucket of overlap: what became of the pairs.
std::string OverlapTable(const std::vector<Trial>& trials);
// Lower ends of the buckets.
inline constexpr double kOverlapBuckets[] = {0, 0.05, 0.15, 0.25, 0.3, 0.6};
// Index of the bucket that an overlap in [0, 1] falls into.
int OverlapBucket(double overlap);

// A row per scenario in which all robots came into one frame: what the map made of their ways, and
// how many are worse for it than by themselves (RobotRmse). Empty if there is none.
std::string TeamTable(const std::vector<Trial>& trials);

// All figures, an entry per pair.
nlohmann::ordered_json ToJson(const Trial& trial);

}  // namespace isthmus::bench
