#include <cmath>
#include <utility>

#include "lab/simulation/wild/scenes.h"

namespace isthmus::simulation::wild {

Motion WalkToAndFro(std::shared_ptr<const Path> path, double speed_mps, double from_m) {
  return [path = std::move(path), speed_mps, from_m](double t) {
    const double all = path->length(), s = from_m + speed_mps * t;
    const double lap = s - 2 * all * std::floor(s / (2 * all));
    return Pose(path->At(lap < all ? lap : 2 * all - lap).position);
  };
}

}  // namespace isthmus::simulation::wild
