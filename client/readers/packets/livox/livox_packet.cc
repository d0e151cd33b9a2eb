#include "client/readers/packets/livox/livox_packet.h"

#include <chrono>
#include <cmath>
#include <iterator>

#include "core/codec/column.h"
#include "core/geometry/angles.h"
#include "core/nanoseconds.h"

namespace isthmus::readers::livox {
namespace {

using codec::LoadAs;

constexpr size_t kSdk1Header = 18;      // Format
constexpr size_t kSdk2Header = 36;      // Format
constexpr uint8_t kSdk1Version = 5;     // Format
constexpr uint8_t kSdk1UtcHour = 3;     // Format: a date, an hour and microseconds within it.
constexpr int64_t kSdk2Interval = 100;  // Format: nanoseconds, of which intervals are multiples.

uint8_t Byte(absl::string_view bytes, size_t at) { return static_cast<uint8_t>(bytes[at]); }

struct Kind {
  size_t firings, firing_bytes, returns;
  Shape shape;
  bool tagged;
};

// By the type of data. Firings of SDK2 are counted in each packet.
constexpr Kind kSdk1Kinds[] = {
    {100, 13, 1, Shape::kMillimetres, false}, {100, 9, 1, Shape::kSpherical, false},
    {96, 14, 1, Shape::kMillimetres, true},   {96, 10, 1, Shape::kSpherical, true},
    {48, 28, 2, Shape::kMillimetres, true},   {48, 16, 2, Shape::kSphericalReturns, true},
    {0, 24, 1, Shape::kMillimetres, false},  // The IMU.
    {30, 42, 3, Shape::kMillimetres, true},   {30, 22, 3, Shape::kSphericalReturns, true}};

std::optional<Kind> KindOf(absl::string_view beginning, size_t length) {
  if (beginning.size() < 11) return std::nullopt;
  if (Byte(beginning, 0) == kSdk1Version) {
    const size_t type = Byte(beginning, 9);
    if (type >= std::size(kSdk1Kinds)) return std::nullopt;
    const Kind kind = kSdk1Kinds[type];
    const size_t firings = kind.firings == 0 ? 1 : kind.firings;
    if (length != kSdk1Header + firings * kind.firing_bytes) return std::nullopt;
    return kind;
  }
  const bool sdk2 = Byte(beginning, 0) == 0 && LoadAs<uint16_t>(beginning.data() + 1) == length;
  if (!sdk2) return std::nullopt;
  Kind kind = {LoadAs<uint16_t>(beginning.data() + 5), 14, 1, Shape::kMillimetres, true};
  switch (Byte(beginning, 10)) {
    case 0:  // The IMU.
      return length == kSdk2Header + 24 ? std::optional<Kind>({0, 24, 1, kind.shape, false})
                                        : std::nullopt;
    case 1:
      break;
    case 2:
      kind.firing_bytes = 8;
      kind.shape = Shape::kCentimetres;
      break;
    case 3:
      kind.firing_bytes = 10;
      kind.shape = Shape::kSpherical;
      break;
    case 0x11:
      kind.firing_bytes = 28;
      kind.returns = 2;
      break;
    default:
      return std::nullopt;
  }
  if (kind.firings == 0 || length != kSdk2Header + kind.firings * kind.firing_bytes) {
    return std::nullopt;
  }
  return kind;
}

// Nanoseconds of UTC from year since 2000, month, day, hour, and microseconds past it.
int64_t UtcOf(absl::string_view stamp) {
  const std::chrono::year_month_day date{std::chrono::year(2000 + Byte(stamp, 0)),
                                         std::chrono::month(Byte(stamp, 1)),
                                         std::chrono::day(Byte(stamp, 2))};
  if (!date.ok()) return 0;
  const int64_t days = std::chrono::sys_days(date).time_since_epoch().count();
  return (days * 24 + Byte(stamp, 3)) * kNsPerHour +
         int64_t{LoadAs<uint32_t>(stamp.data() + 4)} * 1000;
}

// Along the direction of a zenith angle and an azimuth, hundredths of a degree.
Point OnSphere(uint32_t depth_mm, uint16_t zenith, uint16_t azimuth) {
  const double range = depth_mm * 1e-3;
  const double theta = zenith * kRadPerDeg / 100, phi = azimuth * kRadPerDeg / 100;
  return {static_cast<float>(range * std::sin(theta) * std::cos(phi)),
          static_cast<float>(range * std::sin(theta) * std::sin(phi)),
          static_cast<float>(range * std::cos(theta)), 0, 0};
}

template <typename T>
Point OnAxes(const char* at, double unit_m) {
  Point point = {};
  point.x = static_cast<float>(LoadAs<T>(at) * unit_m);
  point.y = static_cast<float>(LoadAs<T>(at + sizeof(T)) * unit_m);
  point.z = static_cast<float>(LoadAs<T>(at + 2 * sizeof(T)) * unit_m);
  return point;
}

}  // namespace

std::optional<Packet> Packet::Parse(absl::string_view bytes) {
  const std::optional<Kind> kind = KindOf(bytes, bytes.size());
  if (!kind) return std::nullopt;
  const bool sdk1 = Byte(bytes, 0) == kSdk1Version;
  Packet packet;
  packet.points_ = bytes.substr(sdk1 ? kSdk1Header : kSdk2Header);
  packet.shape_ = kind->shape;
  packet.firings_ = kind->firings;
  packet.returns_ = kind->returns;
  packet.firing_bytes_ = kind->firing_bytes;
  packet.tagged_ = kind->tagged;
  const absl::string_view stamp = bytes.substr(sdk1 ? 10 : 28, 8);
  const uint64_t time = LoadAs<uint64_t>(stamp.data());
  packet.time_ns_ = time > INT64_MAX ? 0 : static_cast<int64_t>(time);
  if (sdk1 && Byte(bytes, 8) == kSdk1UtcHour) packet.time_ns_ = UtcOf(stamp);
  // SDK2 says how long all firings take.
  if (!sdk1 && kind->firings > 0) {
    packet.interval_ns_ =
        LoadAs<uint16_t>(bytes.data() + 3) * kSdk2Interval / static_cast<int64_t>(kind->firings);
  }
  return packet;
}

Point Packet::PointAt(size_t firing, size_t which_return) const {
  const char* at = points_.data() + firing * firing_bytes_;
  Point point = {};
  const char* end = nullptr;  // End of the coordinates.
  switch (shape_) {
    case Shape::kMillimetres:
      at += which_return * 14;
      point = OnAxes<int32_t>(at, 1e-3);
      end = at + 12;
      break;
    case Shape::kCentimetres:
      point = OnAxes<int16_t>(at, 1e-2);
      end = at + 6;
      break;
    case Shape::kSpherical:
      point = OnSphere(LoadAs<uint32_t>(at), LoadAs<uint16_t>(at + 4), LoadAs<uint16_t>(at + 6));
      end = at + 8;
      break;
    case Shape::kSphericalReturns:
      end = at + 4 + which_return * 6 + 4;
      point = OnSphere(LoadAs<uint32_t>(end - 4), LoadAs<uint16_t>(at), LoadAs<uint16_t>(at + 2));
      break;
  }
  point.reflectivity = LoadAs<uint8_t>(end);
  point.tag = tagged_ ? LoadAs<uint8_t>(end + 1) : uint8_t{0};
  return point;
}

bool MayBeLivoxPacket(absl::string_view beginning, size_t length) {
  const std::optional<Kind> kind = KindOf(beginning, length);
  return kind && kind->firings > 0;
}

}  // namespace isthmus::readers::livox
