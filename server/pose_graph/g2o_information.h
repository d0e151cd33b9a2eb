// Information of planar edges, for .cc files of this folder only.
#pragma once

#include <Eigen/Core>

#include "core/pose.h"

namespace isthmus::pose_graph {

// Information of g2o's [t; q] from that of its planar [x y angle], and back. Off the plane there is
// as much as in it, so that nothing leaves the plane and nothing is stiffer than the rest.
Matrix6d FromPlanarInformation(const Eigen::Matrix3d& planar);
Eigen::Matrix3d ToPlanarInformation(const Matrix6d& g2o);

}  // namespace isthmus::pose_graph
