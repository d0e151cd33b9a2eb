// Grid maps on which simulated storeys are drawn.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>

#include "core/floors/grid_map.h"
#include "lab/simulation/wild/plan.h"

namespace isthmus::bench {

// A map of cells of 0.05 m that holds a plan, turned about its origin. Nothing of it is known.
class Canvas {
 public:
  Canvas(const simulation::wild::Plan& plan, double yaw);

  // Places of the plan's frame, metres.
  size_t CellAt(const Eigen::Vector2d& in_plan) const;
  Eigen::Vector2d InPlan(int64_t x, int64_t y) const;
  Eigen::Vector2d InMap(const Eigen::Vector2d& in_plan) const { return T_map_plan_ * in_plan; }
  const floors::GridMap& map() const { return map_; }

  // Occupies the cells of a copy of the map under the part of a triangle, in the plan's frame, that
  // is 0.1 to 1 m high.
  void Occupy(const std::array<Eigen::Vector3d, 3>& corners, floors::GridMap* map) const;

 private:
  Eigen::Rotation2Dd T_map_plan_;
  floors::GridMap map_;
};

// Frees the unknown cells to which a way leads from one of them.
void FreeFrom(size_t first, floors::GridMap* map);

}  // namespace isthmus::bench
