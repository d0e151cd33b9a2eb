// The name of a content: what tells two uploads apart for certain.
#pragma once

#include <cstddef>
#include <string>

namespace isthmus::io {

inline constexpr size_t kSha256Bytes = 32;  // Format.

// SHA-256 of the bytes. Empty, which is nobody's, where memory ran out.
std::string Sha256(const void* data, size_t size);

}  // namespace isthmus::io
