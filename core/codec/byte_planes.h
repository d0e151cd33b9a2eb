// Single values of byte planes (byte_shuffle.h), in one pass over all planes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/codec/column.h"

namespace isthmus::codec {

// Calls `visitor` with an unsigned integer of `width` bytes: 1, 2, 4 or 8.
template <typename Visitor>
auto VisitWord(size_t width, const Visitor& visitor) {
  switch (width) {
    case 1:
      return visitor(uint8_t{});
    case 2:
      return visitor(uint16_t{});
    case 4:
      return visitor(uint32_t{});
    default:
      return visitor(uint64_t{});
  }
}

// The i-th of n values.
template <typename Word>
Word LoadPlanes(const char* planes, size_t n, size_t i) {
  Word word = 0;
  for (size_t byte = 0; byte < sizeof(Word); ++byte) {
    const auto part = static_cast<Word>(static_cast<uint8_t>(planes[byte * n + i]));
    word = static_cast<Word>(word | static_cast<Word>(part << (8 * byte)));
  }
  return word;
}

template <typename Word>
void StorePlanes(Word word, char* planes, size_t n, size_t i) {
  for (size_t byte = 0; byte < sizeof(Word); ++byte) {
    planes[byte * n + i] = static_cast<char>(word >> (8 * byte));
  }
}

}  // namespace isthmus::codec
