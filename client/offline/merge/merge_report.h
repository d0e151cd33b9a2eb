// The result of `merge`, as JSON and as text.
#pragma once

#include <vector>

#include "client/console/json.h"
#include "client/offline/merge/merge_input.h"
#include "client/offline/merge/merged_files.h"
#include "core/records/map_graph.h"
#include "core/records/map_info.h"

namespace isthmus::cli {

struct MergeResult {
  std::vector<MergeInput> inputs;  // Without their points.
  MapInfo info;
  MatchGraph graph;     // Pairs without sensor poses as DecideBarePairs reports them.
  MergedFiles files;    // Empty names when nothing was merged and so nothing written.
  bool merged = false;  // All of them into one map.
};

// The document of docs/cli.md, "Merging files".
Json ToJson(const MergeResult& result);

// To stdout.
void PrintText(const MergeResult& result);

}  // namespace isthmus::cli
