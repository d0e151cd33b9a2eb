// The name of a content: what tells two uploads apart for certain.
#pragma once

#include <cstddef>
#include <string>

namespace isthmus::codec {

// SHA-256 (FIPS 180-4, section 6.2) of the bytes: 32 bytes.
std::string Sha256(const void* data, size_t size);

}  // namespace isthmus::codec
