// The LZF compression of PCL's binary_compressed data.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <string>

namespace isthmus::formats {

// Two little-endian uint32, the compressed and the uncompressed size, then the compressed bytes.
// ResourceExhausted when either size does not fit.
absl::StatusOr<std::string> LzfBlock(const std::string& content);

// InvalidArgument unless `size` bytes at `block` begin with an undamaged block that unpacks to
// `content_size` bytes. Nothing is allocated for a size that this many bytes cannot unpack to.
absl::StatusOr<std::string> ReadLzfBlock(const char* block, size_t size, size_t content_size);

}  // namespace isthmus::formats
