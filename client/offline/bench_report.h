// The results of `isthmus bench paper`, for people and for scripts.
#pragma once

#include <string>
#include <vector>

#include "client/console/json.h"
#include "client/offline/bench_paper.h"

namespace isthmus::cli {

// A table, line by line as the runs come in.
std::string PaperBenchHeader();
std::string PaperBenchLine(const PaperBenchRun& run);
// Where there are several seeds, a line per world and mode with the means; of the maxima the
// largest, of the lost scans the sum, and an RMSE in one map only if all were merged.
std::string PaperBenchMeans(const std::vector<PaperBenchRun>& runs);

Json ToJson(const PaperBenchOptions& options, const std::vector<PaperBenchRun>& runs);

}  // namespace isthmus::cli
