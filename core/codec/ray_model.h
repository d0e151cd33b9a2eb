// The directions in which a spinning LiDAR measured, as a function of ring and time, so that only
// the distance of a point is news.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace isthmus::codec {

// Most rings of a model; rings are 0 to this, exclusive.
inline constexpr size_t kMaxModelRings = 256;

// One ring: its points lie on x = rho cos a - side sin a, y = rho sin a + side cos a,
// z = rho slope + height, with a = 2 pi (turn + turns_per_unit (time - time of the first point)).
// Lengths are in steps of the quantisation.
struct RingModel {
  float turn = 0, slope = 0, side = 0, height = 0;
};

// The gains by which predictions follow measurements, in 1/256; see RayCoder.
struct RayGains {
  uint8_t distance = 160, speed = 48;  // For the distance and its change from point to point.
  uint8_t azimuth = 16, slope = 16;
};

struct RayModel {
  double turns_per_unit = 0;
  RayGains gains;
  std::vector<RingModel> rings;
};

// The points of a scan in steps, with their rings and times (from the first point's on).
struct RayPoints {
  std::vector<int32_t> x, y, z;
  std::vector<uint8_t> is_return;  // 0: the coordinates mean nothing.
  std::vector<uint16_t> ring;      // Below kMaxModelRings.
  std::vector<double> time;        // Finite.
};

// The model of these points, from a sample of them; none where they follow none, which is quick to
// see. `rings` is one more than the highest ring.
std::optional<RayModel> FitRays(const RayPoints& points, size_t rings);

}  // namespace isthmus::codec
