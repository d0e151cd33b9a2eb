// The part of a map that its own repeats do not explain: the wall at the end of the racks, the one
// door that is narrower. At a wrong place of a world that repeats everything else fits as well.
#pragma once

#include <absl/container/flat_hash_set.h>

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/pose.h"
#include "server/matching/prepared/prepared_submap.h"

namespace isthmus::matching {

// Immutable; safe to read from many threads.
class DistinctiveMap {
 public:
  DistinctiveMap() = default;
  // `up` is a unit vector in odom. `moves` lay the map on itself (SelfSimilarity::Moves).
  DistinctiveMap(const PreparedSubmaps& submaps, const Eigen::Vector3d& up,
                 std::vector<Pose> moves);
  // `before` grown by the submaps that it has not. What they repeat of older ones is theirs alone.
  DistinctiveMap(DistinctiveMap before, const PreparedSubmaps& submaps);

  size_t submaps() const { return submaps_; }

  // True where the map stands upright at a point of its surface (odom), and none of the moves
  // brings that to where it stands as well.
  bool Has(const Eigen::Vector3f& p_odom) const;

 private:
  void Add(const PreparedSubmaps& submaps);
  bool StandsNear(const Eigen::Vector3f& p_odom) const;

  size_t submaps_ = 0;
  Eigen::Vector3d up_ = Eigen::Vector3d::UnitZ();
  std::vector<Pose> moves_;
  absl::flat_hash_set<uint64_t> standing_, distinctive_;  // Voxels.
};

}  // namespace isthmus::matching
