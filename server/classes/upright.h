// The direction of up in a cloud.
#pragma once

#include <Eigen/Core>

#include "server/classes/moments.h"

namespace isthmus::classes {

// A unit vector near `guess`, also one: level surfaces lie across it, upright ones along it. The
// guess where there are too few of either.
Eigen::Vector3f EstimateUp(Moments* moments, const Eigen::Vector3f& guess);

}  // namespace isthmus::classes
