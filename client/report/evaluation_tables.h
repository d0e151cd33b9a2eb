// The errors of trajectories as tables and as JSON.
#pragma once

#include <string>
#include <vector>

#include "client/console/json.h"
#include "client/evaluation/evaluation.h"
#include "client/report/table.h"

namespace isthmus::report {

// Sentences on how the numbers came about: which poses were compared, how the trajectories were
// aligned, which segments were taken.
std::vector<std::string> MethodOf(const evaluation::Evaluation& evaluation);

// Absolute errors (ATE), relative ones (RPE) per frame and per delta, and those per segment as
// KITTI has them; metres, degrees, percent and degrees per 100 m.
std::vector<Table> TablesOf(const evaluation::Evaluation& evaluation);

// All of it, with the keys that docs/cli.md shows.
cli::Json JsonOf(const evaluation::Evaluation& evaluation);

// "1 m", "5 s", "1 frame".
std::string DeltaText(const evaluation::Delta& delta);

}  // namespace isthmus::report
