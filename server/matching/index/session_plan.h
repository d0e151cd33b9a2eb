// The plan of a session's map: seen from above, where something stands upright, which way it faces,
// how high it is, and where the robot looked across. So small that hundreds are kept.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/matching/prepared/prepared_submap.h"

namespace isthmus::matching {

// In the session's level frame: odom's origin, z up. Value type.
struct SessionPlan {
  // A cell in which something stands upright.
  struct Wall {
    Eigen::Vector2f position;  // Centre of the cell.
    Eigen::Vector2f normal;    // Mean of the unit normals, towards the sensor, times the weight.
    float weight = 0;          // (0, 1], how much of the heights it fills.
    bool blocks = false;       // Nobody looks across it.
  };

  float cell_m = 0;
  std::vector<Wall> walls;
  // Cells that were looked across; never a blocking wall's or its neighbour.
  Eigen::Vector2f origin = Eigen::Vector2f::Zero();  // Corner of free cell (0, 0).
  int width = 0, rows = 0;
  std::vector<bool> free;  // Row by row.

  // Circle around walls and free cells.
  Eigen::Vector2f center = Eigen::Vector2f::Zero();
  float radius = 0;

  size_t bytes() const {
    return sizeof(SessionPlan) + walls.capacity() * sizeof(Wall) + free.capacity() / 8;
  }
  // Sum of the walls' weights.
  double Weight() const;
  bool IsFree(const Eigen::Vector2f& position) const;
  Eigen::Vector2f FreeCenter(size_t i) const {
    const size_t column = i % width, row = i / width;
    return origin + cell_m * Eigen::Vector2f(static_cast<float>(column) + 0.5f,
                                             static_cast<float>(row) + 0.5f);
  }
};

// Empty for maps in which nothing stands upright and for such as reach farther than a plan can. The
// vertical is taken to be near odom's z: of a sensor mounted upside down the plan is a mirror image
// and finds no partners. Some 50 ms for a session of 5 submaps.
SessionPlan MakeSessionPlan(const PreparedSubmaps& submaps);

// The same in cells that are a power of two times as large.
SessionPlan Coarsen(const SessionPlan& plan, float cell_m);

}  // namespace isthmus::matching
