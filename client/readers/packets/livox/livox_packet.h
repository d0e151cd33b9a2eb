// A data packet of a Livox sensor: points, each with its time, in one of the maker's layouts.
// Livox SDK Communication Protocol (Avia, Mid-40, Mid-70, Horizon, Tele-15) and Livox LiDAR
// Communication Protocol for SDK2 (Mid-360, HAP), "Point Cloud Data".
#pragma once

#include <absl/strings/string_view.h>

#include <cstddef>
#include <cstdint>
#include <optional>

namespace isthmus::readers::livox {

struct Point {
  float x, y, z;  // Metres, in the sensor's frame; all 0: no return.
  uint8_t reflectivity;
  uint8_t tag;  // Kind of return; 0 in layouts without.
};

// The way in which the places of points are written.
enum class Shape : uint8_t { kMillimetres, kCentimetres, kSpherical, kSphericalReturns };

// A view of a packet, good as long as its bytes.
class Packet {
 public:
  // Empty for what is no packet. One that holds no points, but what the IMU says, has none.
  static std::optional<Packet> Parse(absl::string_view bytes);

  size_t firings() const { return firings_; }
  size_t returns() const { return returns_; }  // Per firing.
  Point PointAt(size_t firing, size_t which_return) const;

  // The time of the first firing, nanoseconds of the sensor's clock.
  int64_t time_ns() const { return time_ns_; }
  // Nanoseconds from firing to firing, as the packet says; 0: it does not.
  int64_t interval_ns() const { return interval_ns_; }

 private:
  absl::string_view points_;
  Shape shape_ = Shape::kMillimetres;
  size_t firings_ = 0, returns_ = 1, firing_bytes_ = 0;
  bool tagged_ = true;
  int64_t time_ns_ = 0, interval_ns_ = 0;
};

// True if the datagram may hold points of Livox'. `beginning` may be cut.
bool MayBeLivoxPacket(absl::string_view beginning, size_t length);

}  // namespace isthmus::readers::livox
