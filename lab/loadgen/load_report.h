// The report of a run of the load generator, as text and as JSON.
#pragma once

#include <string>
#include <vector>

#include "client/console/json.h"
#include "lab/loadgen/load_run.h"

namespace isthmus::loadgen {

// Quantiles of any number of values; all 0 if there are none. By the nearest rank.
struct Spread {
  double p50 = 0, p90 = 0, p99 = 0, max = 0;
};
Spread SpreadOf(std::vector<double> values);

std::string ToText(const LoadResult& result);
cli::Json ToJson(const LoadResult& result);

// True if every scan that was pushed was acknowledged and no robot ended with an error.
bool AllAnswered(const LoadResult& result);

}  // namespace isthmus::loadgen
