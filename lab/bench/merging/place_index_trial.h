// The place index by itself: which share of the pairs of many sessions has to be searched to find
// those that overlap.
#pragma once

#include <absl/status/status.h>

#include <iosfwd>

#include "lab/bench/merging/drive_cache.h"
#include "lab/bench/merging/wild_pairs.h"
#include "server/pipeline_options.h"

namespace isthmus::bench {

struct PlaceIndexOptions {
  WildPairsOptions wild;
  int parts = 2;  // Each drive is cut into so many sessions.
  // Also what a server with these options does with the sessions.
  bool search = false;
  server::PipelineOptions server = {};
};

// Fills the cache with the drives.
absl::Status DriveForPlaceIndex(const PlaceIndexOptions& options, DriveCache& cache);

// Compares all sessions' plans, and writes tables (Markdown).
absl::Status RunPlaceIndex(const PlaceIndexOptions& options, DriveCache& cache, std::ostream& out);

}  // namespace isthmus::bench
