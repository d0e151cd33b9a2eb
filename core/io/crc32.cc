#include "core/io/crc32.h"

#include <zlib.h>

namespace isthmus::io {

uint32_t Crc32(absl::string_view bytes, uint32_t seed) {
  if (bytes.empty()) return seed;  // To zlib no bytes would mean a new checksum.
  return static_cast<uint32_t>(
      crc32_z(seed, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace isthmus::io
