// The overlap of two simulated robots' views of the world.
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_set>

#include "core/pose.h"
#include "core/scan.h"

namespace isthmus::simulation {

// The surface a robot has measured, as cubic cells of the world. Not thread safe.
class SeenSurface {
 public:
  explicit SeenSurface(double cell_m) : cell_m_(cell_m) {}

  void Add(const Scan& scan, const Pose& T_world_sensor);
  size_t cells() const { return cells_.size(); }

  // Both must have the same size of cells. Share of the cells of the one with fewer of them that
  // the other has too, [0, 1].
  static double Overlap(const SeenSurface& a, const SeenSurface& b);

 private:
  double cell_m_;
  std::unordered_set<uint64_t> cells_;
};

}  // namespace isthmus::simulation
