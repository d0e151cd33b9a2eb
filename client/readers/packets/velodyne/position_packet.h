// A position packet of a Velodyne sensor: its clock beside the GPRMC sentence of its GNSS receiver.
// VLP-16 User Manual (63-9243 Rev. E) 9.3.3, HDL-32E User Manual appendix; NMEA 0183.
#pragma once

#include <absl/strings/string_view.h>

#include <cstddef>
#include <cstdint>
#include <optional>

namespace isthmus::readers::velodyne {

inline constexpr size_t kPositionPacketBytes = 512;  // Format

struct PositionPacket {
  uint32_t microseconds = 0;   // Past the hour, of the sensor's clock.
  absl::string_view sentence;  // "$GPRMC,...", without what follows its end.
};

// Empty for anything else, and where the receiver has sent no sentence.
std::optional<PositionPacket> ParsePositionPacket(absl::string_view bytes);

struct GprmcFix {
  int64_t stamp_ns = 0;  // UTC, nanoseconds since the Unix epoch.
  double latitude_deg = 0, longitude_deg = 0;
};

// A sentence of status A (valid) of any talker (GPRMC, GNRMC). Empty for others, for what is no
// time or place on Earth, and where a checksum is given that does not fit.
std::optional<GprmcFix> ParseGprmc(absl::string_view sentence);

}  // namespace isthmus::readers::velodyne
