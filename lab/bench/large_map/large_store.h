// A store as a server leaves it that robots have mapped a city with for weeks.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>

#include "lab/bench/large_map/city.h"
#include "storage/map_store.h"

namespace isthmus::bench {

struct LargeStoreOptions {
  double bytes = 1e9;  // On disk, about; the last submap goes beyond.
  int robots = 5;      // Sessions are theirs in turn.
  int submaps_per_session = 100;
  unsigned seed = 1;
  CityOptions city = {};
};

// Bytes of all files in the folder.
double BytesOnDisk(const std::string& folder);

// Writes finished sessions until the folder holds that much. All lie in one component, joined by
// hand; every pair has been compared, so nothing is left to estimate. The robots' odometry does not
// stray. Behind the city's whole way (some 3 GB) they see again what was seen there first.
absl::Status FillStore(const LargeStoreOptions& options, const std::string& folder);

}  // namespace isthmus::bench
