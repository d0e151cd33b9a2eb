// The CRC-32 of MCAP.
#pragma once

#include <absl/strings/string_view.h>

#include <cstdint>

namespace isthmus::readers {

// ISO 3309 as in zlib and PNG (polynomial 0x04C11DB7, reflected); `so_far` is that of the bytes
// before.
uint32_t Crc32(absl::string_view bytes, uint32_t so_far = 0);

}  // namespace isthmus::readers
