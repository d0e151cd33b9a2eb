// The likeness of a map with itself elsewhere: racks, rooms, rows of trees. In a world that repeats
// a good fit says less, and where one way to lay maps on each other fits, others are near at hand.
#pragma once

#include <cstddef>
#include <vector>

#include "core/pose.h"
#include "server/matching/registration/refine.h"
#include "server/matching/search/wall_map.h"

namespace isthmus::matching {

struct SelfSimilarity {
  struct Repeat {
    Pose T_odom_odom;   // Moves the map onto itself.
    double degree = 0;  // Its fit there; in place it is 1.
  };
  std::vector<Repeat> repeats;  // Best first.
  double degree() const { return repeats.empty() ? 0 : repeats.front().degree; }
  // The best `most` of those that count (kMinRepeatDegree), each followed by its inverse.
  std::vector<Pose> Moves(size_t most) const;
};

// The share of a surface that lies on another, less if it does so loosely: `overlap` if it lies
// there exactly, 0 if its distances are as if at random within kOnSurfaceM.
double TightOverlap(double overlap, double residual_m);

// By the bird's-eye search of the map in itself. Deterministic; thread safe.
SelfSimilarity MeasureSelfSimilarity(const WallMap& walls, const RefinableMap& refinable,
                                     const RefineOptions& options);

}  // namespace isthmus::matching
