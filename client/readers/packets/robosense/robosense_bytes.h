// Numbers in the packets of RoboSense's, the most significant byte first.
#pragma once

#include <absl/strings/string_view.h>

#include <cstddef>
#include <cstdint>

namespace isthmus::readers::robosense {

inline constexpr size_t kPacketBytes = 1248;  // Format: of every packet.

// Within the bytes.
inline uint8_t ByteAt(absl::string_view bytes, size_t at) {
  return static_cast<uint8_t>(bytes[at]);
}
inline uint16_t BigAt16(absl::string_view bytes, size_t at) {
  return static_cast<uint16_t>(ByteAt(bytes, at) << 8 | ByteAt(bytes, at + 1));
}
inline uint32_t BigAt32(absl::string_view bytes, size_t at) {
  return static_cast<uint32_t>(BigAt16(bytes, at)) << 16 | BigAt16(bytes, at + 2);
}

}  // namespace isthmus::readers::robosense
