// Revisions, loop closures and anchors as JSON; see json.h.
#pragma once

#include "client/console/json.h"
#include "core/records/map_graph.h"

namespace isthmus::cli {

Json ToJson(const RevisionInfo& revision);
// Poses that a submap did not have are null; so are move_m and move_deg where it came, went or
// changed its frame.
Json ToJson(const SubmapMove& move);
Json ToJson(const RevisionDiff& diff);
// `with_edges`: with the submaps that carry it, as "edges".
Json ToJson(const Loop& loop, bool with_edges = false);
Json ToJson(const RobotAnchor& anchor);

}  // namespace isthmus::cli
