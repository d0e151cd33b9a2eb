// What `isthmus merge` says of every pair of maps.
#pragma once

#include <string>
#include <vector>

#include "client/console/json.h"
#include "client/offline/merge/merge_input.h"
#include "core/records/map_graph.h"
#include "core/records/map_info.h"

namespace isthmus::cli {

struct MergeResult {
  std::vector<MergeInput> inputs;  // Without their points.
  MapInfo info;
  MatchGraph graph;     // Pairs without sensor poses as DecideBarePairs reports them.
  std::string output;   // Empty when nothing was merged and so nothing written.
  bool merged = false;  // All of them into one map.
};

Json ToJson(const MergeResult& result);
void PrintText(const MergeResult& result);

}  // namespace isthmus::cli
