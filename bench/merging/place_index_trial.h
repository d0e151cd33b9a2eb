// The place index by itself: which share of the pairs of many sessions has to be searched to find
// those that overlap.
#pragma once

#include <absl/status/status.h>

#include <iosfwd>

#include "bench/merging/drive_cache.h"
#include "bench/merging/wild_pairs.h"

namespace isthmus::bench {

struct PlaceIndexOptions {
  WildPairsOptions wild;
  int parts = 2;  // Each drive is cut into so many sessions.
};

// Fills the cache with the drives.
absl::Status DriveForPlaceIndex(const PlaceIndexOptions& options, DriveCache& cache);

// Compares all sessions' plans, matches nothing, and writes tables (Markdown).
absl::Status RunPlaceIndex(const PlaceIndexOptions& options, DriveCache& cache, std::ostream& out);

}  // namespace isthmus::bench
