// A session's map with everything the matcher needs of it, made once and used against many others.
#pragma once

#include "core/stopwatch.h"
#include "core/submap.h"
#include "server/matching/free_space.h"
#include "server/matching/refine.h"
#include "server/matching/wall_map.h"

namespace isthmus::matching {

// Immutable; safe to read from many threads. Holds on to the submaps.
class PreparedMap {
 public:
  explicit PreparedMap(const SessionMap& map);

  const SessionMap& session_map() const { return map_; }
  const RefinableMap& refinable() const { return refinable_; }
  const WallMap& walls() const { return walls_; }
  const FreeSpaceMap& free_space() const { return free_space_; }
  // Of the refinable map: coarser outdoors.
  const RefineOptions& refine_options() const { return refine_options_; }
  // What it took to make, wall time.
  double prepare_ms() const { return prepare_ms_; }

 private:
  Stopwatch watch_;  // First, to time the making of the others.
  SessionMap map_;
  RefineOptions refine_options_;  // Set while refinable_ is made.
  RefinableMap refinable_;
  WallMap walls_;
  FreeSpaceMap free_space_;
  double prepare_ms_ = 0;
};

}  // namespace isthmus::matching
