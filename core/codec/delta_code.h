// Whole numbers as differences to the one before, signs folded in, so that small steps become small
// numbers: 0, -1, 1, -2, 2 ... are coded 1, 2, 3, 4, 5. Code 0 stands for "no value".
#pragma once

#include <cstdint>

namespace isthmus::codec {

// Values must be smaller in magnitude; their differences then fit the 32-bit code.
inline constexpr int32_t kMaxDeltaCodeValue = 1 << 29;
inline constexpr uint32_t kNoValueCode = 0;

class DeltaEncoder {
 public:
  uint32_t Encode(int32_t value) {
    const int32_t delta = value - previous_;
    previous_ = value;
    return ((static_cast<uint32_t>(delta) << 1) ^ static_cast<uint32_t>(delta >> 31)) + 1;
  }

 private:
  int32_t previous_ = 0;
};

// Takes any code but kNoValueCode; damaged ones give wrong values, nothing worse.
class DeltaDecoder {
 public:
  int32_t Decode(uint32_t code) {
    const uint32_t folded = code - 1;
    previous_ += (folded >> 1) ^ (~(folded & 1) + 1);
    return static_cast<int32_t>(previous_);
  }

 private:
  uint32_t previous_ = 0;  // Unsigned: wraps where a damaged code overflows.
};

}  // namespace isthmus::codec
