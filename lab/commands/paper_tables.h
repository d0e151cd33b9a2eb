// The paper's comparison side by side, one column per odometry.
#pragma once

#include <vector>

#include "client/report/table.h"
#include "lab/commands/bench_paper.h"

namespace isthmus::cli {

// Three tables: errors (Table 3), run time (Table 4), run time stage by stage (Table 5). A column
// per odometry, in the order MR-FLOAM, MR-ALOAM, ours; a row per world and quantity: means over the
// seeds, of maxima the largest, of lost scans the sum. An error in one map is "not merged" unless
// all seeds were.
std::vector<report::Table> PaperTables(const std::vector<PaperBenchRun>& runs);

}  // namespace isthmus::cli
