// The checksum of records, blobs and uploads.
#pragma once

#include <cstddef>
#include <cstdint>

namespace isthmus::io {

// CRC-32C (Castagnoli, as in iSCSI, RFC 3720 B.4) of the bytes. To continue over a further piece,
// pass the result for the first as `seed`. Uses the processor's instruction where there is one.
uint32_t Crc32c(const void* data, size_t size, uint32_t seed = 0);

namespace internal {
// The table-driven form, whatever the processor; for tests and other machines.
uint32_t Crc32cPortable(const void* data, size_t size, uint32_t seed = 0);
}  // namespace internal

}  // namespace isthmus::io
