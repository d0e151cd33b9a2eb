// A plan of what stands low over the ground, and which of it is wall.
#pragma once

#include <absl/container/flat_hash_map.h>
#include <absl/container/flat_hash_set.h>

#include <Eigen/Core>
#include <cstdint>

namespace isthmus::matching {

// Cells of kThingVoxelM, storey by storey, level frame. Value type; as thread safe as a vector.
class LowPlan {
 public:
  // A point that was seen `height_m` over the ground.
  void Add(const Eigen::Vector2f& p, int storey, float height_m);

  // True in a cell of a wall or beside one. A wall is a straight stretch of kWallM in which
  // something stands upright all along.
  bool IsAtWall(const Eigen::Vector2f& p, int storey) const;

 private:
  struct Heights {
    float lowest = 0, highest = 0;
  };
  bool IsOfWall(const Eigen::Vector2f& p, int storey) const;
  // The stretch begins `first` steps from p.
  bool IsFilled(const Eigen::Vector2f& p, const Eigen::Vector2f& along, int first,
                int storey) const;

  absl::flat_hash_map<uint64_t, Heights> cells_;
  absl::flat_hash_set<uint64_t> upright_;  // Cells in which something stands, and those beside.
};

}  // namespace isthmus::matching
