// Moving a component as a whole to where its anchors say that it is.
#pragma once

#include "core/pose.h"
#include "server/placement/graph.h"
#include "server/placement/placer.h"

namespace isthmus::placement {

// The rigid motion that takes problem.poses nearest to its anchors, by the sum of distances, of
// those that one anchor with a heading or two with positions give: a start for the optimiser that a
// wrong anchor among several does not spoil. Positions turn it about the vertical only; a single
// one does not turn it. Identity without anchors.
Pose FitToAnchors(const pose_graph::Problem& problem);

// Two of three turns are known where the odometry's vertical is the map's: where no anchor holds
// the attitude, the vertical of the gauge node's odom frame does, to 2 degrees. Else a map would
// tilt to be a little shorter in plan, as noisy positions would have it.
void KeepUpright(const Input& input, Graph* graph);

}  // namespace isthmus::placement
