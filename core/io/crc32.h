// The checksum of MCAP files.
#pragma once

#include <absl/strings/string_view.h>

#include <cstdint>

namespace isthmus::io {

// CRC-32 of ISO 3309, by zlib. To continue over a further piece, pass the result for the first as
// `seed`.
uint32_t Crc32(absl::string_view bytes, uint32_t seed = 0);

}  // namespace isthmus::io
