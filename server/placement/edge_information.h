// Information matrices for the edges and anchors of the graph.
#pragma once

#include "core/map/anchor.h"
#include "server/placement/placer.h"
#include "server/pose_graph/information.h"

namespace isthmus::placement {

// The information of the odometry from one node of a session to the next: the covariance of the
// drift model over the distance travelled and that of the odometry itself, added up. Where submaps
// in between were retired the way is taken to be as long for each of them.
Matrix6d DriftInformation(const Node& before, const Node& node,
                          const pose_graph::DriftModel& drift);

// The same standard deviation along each axis, and about any.
Matrix6d IsotropicInformation(double position_m, double rotation_rad);

// In the convention of pose_graph::Anchor.
Matrix6d AnchorInformation(const Anchor& anchor);

// True if the optimiser takes an edge with these numbers.
bool IsUsable(const Pose& T_a_b, const Matrix6d& information);

}  // namespace isthmus::placement
