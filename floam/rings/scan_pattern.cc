#include "floam/rings/scan_pattern.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/geometry/angles.h"
#include "floam/rings/limits.h"

namespace isthmus::floam {
namespace {

float Elevation(const RingPoint& p) { return FastAtan2(p.z, std::sqrt(p.x * p.x + p.y * p.y)); }

// Azimuth and elevation of the points of a ring, in order of azimuth.
std::vector<std::pair<float, float>> Directions(const RingScan& scan, size_t ring) {
  std::vector<std::pair<float, float>> directions;
  for (uint32_t i = scan.ring_begin[ring]; i < scan.ring_begin[ring + 1]; ++i) {
    const RingPoint& p = scan.points[i];
    if (p.range > kClearElevationM) directions.emplace_back(FastAtan2(p.y, p.x), Elevation(p));
  }
  std::sort(directions.begin(), directions.end());
  return directions;
}

}  // namespace

absl::Status NotSpinning(uint64_t sequence, const std::string& what_was_seen) {
  return absl::InvalidArgumentError(absl::StrCat(
      "scan ", sequence, " does not lie in rings: ", what_was_seen,
      ". This looks like a non-repetitive scan pattern (Livox and the like): open the session with "
      "the sensor \"unordered\". If the sensor spins, send a field \"ring\" with the laser of each "
      "point, and points in the sensor's own frame"));
}

absl::Status CheckSpinning(const RingScan& scan, uint64_t sequence) {
  std::vector<float> jumps;
  for (size_t ring = 0; ring + 1 < scan.ring_begin.size(); ++ring) {
    if (scan.ring_begin[ring + 1] - scan.ring_begin[ring] < kMinRingPoints) continue;
    const auto directions = Directions(scan, ring);
    for (size_t i = 1; i < directions.size(); ++i) {
      if (directions[i].first - directions[i - 1].first > kRingNeighbourRad) continue;
      jumps.push_back(std::abs(directions[i].second - directions[i - 1].second));
    }
  }
  if (jumps.empty()) return absl::OkStatus();  // All is near: nothing to tell by.
  const auto middle = jumps.begin() + static_cast<std::ptrdiff_t>(jumps.size() / 2);
  std::nth_element(jumps.begin(), middle, jumps.end());
  if (*middle <= kMaxRingJumpRad) return absl::OkStatus();
  return NotSpinning(sequence, absl::StrCat("elevations change by ", std::round(*middle / kDegree),
                                            " deg from one point of a ring to the next"));
}

absl::Status CheckRingCount(uint64_t sequence, int lowest_ring, int highest_ring,
                            const SensorModel& model) {
  // Some drivers count from 1.
  const int first = lowest_ring > 0 ? 1 : 0;
  if (model.rings == 0 || highest_ring - first < model.rings) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("scan ", sequence, " has rings up to number ", highest_ring, ", but a ",
                   model.name, " has ", model.rings,
                   "; open the session with the name of the sensor that was used, or with "
                   "\"spinning\" to have everything found from the scans"));
}

std::string ElevationMismatch(const RingScan& scan, const SensorModel& model) {
  if (model.elevations.empty()) return "";
  std::vector<float> seen;
  for (const RingPoint& p : scan.points) {
    if (p.range > kClearElevationM) seen.push_back(Elevation(p));
  }
  if (seen.size() < kMinRingPoints) return "";
  std::sort(seen.begin(), seen.end());
  const auto outlying = static_cast<size_t>(kOutlyingShare * static_cast<float>(seen.size()));
  const float low = seen[outlying], high = seen[seen.size() - 1 - outlying];
  const auto least = static_cast<float>(model.elevations.front());
  const auto most = static_cast<float>(model.elevations.back());
  if (low > least - kElevationSlackRad && high < most + kElevationSlackRad) return "";
  const auto degrees = [](float angle) { return std::round(angle / kDegree); };
  return absl::StrCat("elevations are ", degrees(low), " to ", degrees(high), " deg, but a ",
                      model.name, " has ", degrees(least), " to ", degrees(most));
}

}  // namespace isthmus::floam
