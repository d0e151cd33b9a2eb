// The match graph as markers for RViz.
#pragma once

#include <ros/time.h>
#include <visualization_msgs/MarkerArray.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/records/map_graph.h"
#include "core/records/map_reading.h"

namespace isthmus::ros1 {

struct MarkerOptions {
  std::string frame = "map";
  ros::Time stamp = {};
  uint32_t component = 0;  // The map frame is this component's.
  double size_m = 1;       // Size of a session's ball.
};

// Replaces all markers that were there before. Namespaces, each to be hidden by itself:
//   sessions    a ball per session: blue in this map, grey where an undecided match has it
//   names       its id, above it
//   accepted    green lines
//   undecided   yellow lines: matches that are open, see docs/concepts.md
//   confidence  in the middle of each line the probability; of open ones with the reason
// Rejected matches are not drawn, nor are sessions that have no place in this map.
visualization_msgs::MarkerArray MakeMarkers(const MatchGraph& graph,
                                            const std::vector<SubmapStatus>& submaps,
                                            const MarkerOptions& options);

}  // namespace isthmus::ros1
