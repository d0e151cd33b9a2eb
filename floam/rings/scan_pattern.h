// A test whether scans are those of a spinning LiDAR, and of the one that was named.
#pragma once

#include <absl/status/status.h>

#include <string>

#include "floam/rings/ring_scan.h"
#include "floam/rings/sensor_model.h"

namespace isthmus::floam {

// The error for points that do not lie in rings.
absl::Status NotSpinning(uint64_t sequence, const std::string& what_was_seen);

// A laser of a spinning LiDAR looks at the same elevation all the way round, or, where points were
// turned into another frame, at one that changes slowly: InvalidArgument when elevations jump
// between points of a ring that are neighbours in azimuth, as they do where a pattern does not
// repeat (Livox). Takes about as long as sorting the scan; once per session is enough.
absl::Status CheckSpinning(const RingScan& scan, uint64_t sequence);

// InvalidArgument when the scan has more rings than the named sensor; OK for a model without rings.
absl::Status CheckRingCount(uint64_t sequence, int lowest_ring, int highest_ring,
                            const SensorModel& model);

// In words, what speaks against the scan being that of `model`: "elevations -25 to 15 deg, a vlp16
// has -15 to 15". Empty when nothing does.
std::string ElevationMismatch(const RingScan& scan, const SensorModel& model);

}  // namespace isthmus::floam
