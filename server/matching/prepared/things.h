// The things that stand about in a map under a roof: furniture, cars, boxes, plants. Buildings
// repeat their walls; where things stand, to the centimetre, they do not.
#pragma once

#include <absl/container/flat_hash_set.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/map/submap.h"
#include "core/pose.h"
#include "server/matching/prepared/low_plan.h"
#include "server/matching/prepared/prepared_submap.h"
#include "server/matching/registration/kd_tree.h"

namespace isthmus::matching {

// The other map's say on one map's things. Sums, so that those of submaps can be added.
struct ThingAgreement {
  int64_t there = 0;  // They stand in the other map as well.
  int64_t gone = 0;   // The other robot looked through where they stand.
  ThingAgreement& operator+=(const ThingAgreement& other) {
    there += other.there;
    gone += other.gone;
    return *this;
  }
};

// A map's things, by its submaps. A thing is what stands in a square of kThingM between
// kThingsFromM and kThingsToM over the ground and is no straight stretch of kWallM: a wide cupboard
// counts as a wall. Immutable; safe to read from many threads.
class Things {
 public:
  Things() = default;
  // `T_level_odom` makes the map level. Reads the submaps' points.
  Things(const SessionMap& map, const PreparedSubmaps& submaps, const Pose& T_level_odom)
      : Things(Things(), map, submaps, T_level_odom) {}
  // `before` grown by the submaps that it has not. What it took for things stays so, though more of
  // the wall that they belong to may have been seen.
  Things(Things before, const SessionMap& map, const PreparedSubmaps& submaps,
         const Pose& T_level_odom);

  size_t submaps() const { return pieces_.size(); }
  size_t CountIn(size_t k) const { return pieces_[k]->things.size(); }  // Things of submap k.

  // The agreement of submap k's things with another map. `T_common_submap` and `T_common_other`
  // place it and the other's submaps in one frame.
  ThingAgreement In(const Things& other, size_t k, const Pose& T_common_submap,
                    const std::vector<Pose>& T_common_other) const;

 private:
  using Thing = std::vector<Eigen::Vector3f>;  // At most kThingPoints points, submap frame.
  struct Piece {
    std::shared_ptr<const PreparedSubmap> submap;
    std::vector<Thing> things;  // A thing that several submaps show is the first one's.
    Eigen::Matrix3f flatten;    // Brings the heights of the submap frame nearer to each other.
    KdTree low;                 // All that was seen at that height, walls too; flattened.
  };
  class Target;  // A piece that is asked about points of a submap.

  // The pieces from `first` on that the submap meets.
  std::vector<Target> TargetsOf(const PreparedSubmap& submap, const Pose& T_common_submap,
                                const std::vector<Pose>& T_common_pieces, size_t first) const;
  // Takes out what views of the map itself look through, those from submap `first_new` on for
  // pieces before it.
  void DropFleeting(size_t first_new);

  std::vector<std::shared_ptr<const Piece>> pieces_;  // By submap.
  absl::flat_hash_set<uint64_t> taken_;               // Squares of the level frame with a thing.
  LowPlan plan_;
};

}  // namespace isthmus::matching
