// A cloud that another program decoded from the same recording, and how far ours is from it.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "core/point_payload.h"

namespace isthmus::bench {

// Points of one or more scans, one after the other. `rings` is empty where there are none.
struct PointList {
  std::vector<double> x, y, z, rings;

  size_t size() const { return x.size(); }
  // InvalidArgument for a cloud without x y z.
  absl::Status Append(const PointPayload& payload);
};

struct Agreement {
  size_t reference_points = 0, matched = 0;
  size_t skipped = 0;      // Points of ours between the first and the last that matched.
  bool same_order = true;  // All were found going forward through both.
  size_t rings_compared = 0, rings_equal = 0;
  // Differences of the matched: metres apart, along the beam, in height, and degrees of azimuth
  // (theirs behind ours: positive, clockwise), the last by ring, too.
  std::vector<double> distance, range, height, azimuth;
  std::map<int, std::vector<double>> azimuth_of_ring;
};

// Goes through both in order and takes for the same point what has the same range and height to
// `tolerance_m`; azimuths may differ, since programs interpolate them differently.
Agreement Compare(const PointList& reference, const PointList& ours, double tolerance_m);

// InvalidArgument or NotFound, naming the file.
absl::StatusOr<PointList> ReadReference(const std::string& path);

}  // namespace isthmus::bench
