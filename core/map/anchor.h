// A submap whose place is known from outside: surveyed, or measured by GNSS.
#pragma once

#include <cstdint>
#include <string>

#include "core/ids.h"
#include "core/pose.h"

namespace isthmus {

// The map frame of a component with anchors is the frame in which they are given: one for the whole
// site, z up, metres. Coordinates beyond kMaxAnchorM of its origin are refused, because maps are
// served as 32-bit floats.
struct Anchor {
  SubmapId submap;  // One anchor each.
  Pose T_map_submap;
  // Standard deviations, along each axis of the map and about any; 0: that part is not known, and
  // what T_map_submap says of it is not looked at. At least one is positive.
  double sigma_xy_m = 0;
  double sigma_z_m = 0;
  double sigma_deg = 0;
  std::string note;      // Why, in the person's own words; may be empty.
  int64_t given_ns = 0;  // Unix nanoseconds.
};

inline constexpr double kMaxAnchorM = 20'000;
// Metres or degrees: what claims to be known better would lose its weight to rounding.
inline constexpr double kMinAnchorSigma = 1e-6;

}  // namespace isthmus
