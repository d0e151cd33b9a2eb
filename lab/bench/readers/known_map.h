// A large map of tiny submaps: what readers are given lists of.
#pragma once

#include <absl/status/status.h>

#include "storage/map_store.h"

namespace isthmus::bench {

struct KnownMapOptions {
  int sessions = 100;  // Finished, each of a robot of its own.
  int submaps = 100;   // Per session, one metre apart.
  int loops = 20;      // Per session.
};

// Writes the map. All lies in one component, joined by hand, and every pair has been compared, so
// nothing is left to estimate.
absl::Status WriteKnownMap(const KnownMapOptions& options, storage::MapStore* store);

}  // namespace isthmus::bench
