// The area of the ground that two robots both know under a hypothesis.
#pragma once

#include <Eigen/Core>

#include "core/pose.h"
#include "server/matching/search/birds_eye_image.h"

namespace isthmus::matching {

struct SharedArea {
  double area_m2 = 0;
  double share = 0;  // Share of the ground that the map that knows more knows, [0, 1].
  Eigen::Vector2d center = Eigen::Vector2d::Zero();  // In a's level frame.
};

// From the known cells of both; cells of equal size.
SharedArea MeasureSharedArea(const BirdsEyeCells& a, const BirdsEyeCells& b,
                             const Pose& T_level_a_level_b);

}  // namespace isthmus::matching
