// The report of a mapping benchmark: Markdown tables, and the same as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "lab/bench/mapping/false_loops.h"
#include "lab/bench/mapping/laps_trial.h"
#include "lab/bench/mapping/map_trial.h"
#include "lab/bench/mapping/next_day_trial.h"
#include "lab/bench/mapping/undo_trial.h"

namespace isthmus::bench {

// All that was run.
struct MappingResults {
  std::vector<MapTrial> maps;
  std::vector<FalseLoopsTrial> false_loops;
  LapsTrial laps;
  std::vector<UndoTrial> undo;
  std::vector<NextDayTrial> next_days;
};

std::string LapsHeader();
std::string ToLine(const LapsRow& row);

// Tables of the results.
std::string MappingTables(const MappingResults& results);
nlohmann::ordered_json ToJson(const MappingResults& results);

}  // namespace isthmus::bench
