// The contents of a map folder, and their differences from what should be there.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/map/submap.h"
#include "core/map/trajectory.h"

namespace isthmus::faults {

struct StoredSession {
  std::vector<std::shared_ptr<const Submap>> submaps;
  std::vector<TrajectoryEntry> trajectory;
};
using StoredMap = std::map<SessionId, StoredSession>;

// The map in the folder, or in the PostgreSQL database `store`. Throws where it cannot be read. No
// server may be on it.
StoredMap ReadStoredMap(const std::string& folder, const std::string& store = "");

struct MapDifference {
  uint64_t scans = 0, submaps = 0;            // In the map that was looked at.
  uint64_t missing_scans = 0, odd_scans = 0;  // Odd: not in the reference.
  uint64_t repeated_scans = 0;
  uint64_t other_submaps = 0;  // Missing, odd, or covering other scans.
  uint64_t other_points = 0;   // Submaps whose points or keyframes are not bit for bit the same.
  double rmse_m = 0, max_m = 0;
  bool same_bits = true;  // All poses and points are the same bits.
};

MapDifference Compare(const StoredMap& reference, const StoredMap& map);

}  // namespace isthmus::faults
