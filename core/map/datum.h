// The place on the Earth at which the site's frame lies.
#pragma once

#include <absl/status/status.h>

#include <cmath>
#include <cstdint>

namespace isthmus {

// The origin of the frame in which anchors are given, WGS 84, and how that frame is turned.
struct Datum {
  double latitude_deg = 0;   // [-90, 90].
  double longitude_deg = 0;  // [-180, 180].
  double altitude_m = 0;     // Above the ellipsoid; at most kMaxAltitudeM from it.
  // The direction of the frame's y axis at the origin, clockwise from north: 0 for x east, y north.
  double heading_deg = 0;  // [-360, 360].
  int64_t given_ns = 0;    // Unix nanoseconds.
};

inline constexpr double kMaxAltitudeM = 100'000;

// InvalidArgument for what is out of range or not finite.
inline absl::Status CheckDatum(const Datum& datum) {
  // Written so that NaN fails too.
  if (std::abs(datum.latitude_deg) <= 90 && std::abs(datum.longitude_deg) <= 180 &&
      std::abs(datum.altitude_m) <= kMaxAltitudeM && std::abs(datum.heading_deg) <= 360) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      "a datum has a latitude of -90 to 90, a longitude of -180 to 180 and a heading of -360 to "
      "360 degrees, and an altitude within 100 km");
}

}  // namespace isthmus
