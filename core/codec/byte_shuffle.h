// Byte planes: the first byte of every value, then the second of every value, and so on. Numbers
// that differ little then have long runs of equal bytes, which a general compressor finds.
#pragma once

#include <cstddef>

namespace isthmus::codec {

// `in` holds n values of `width` bytes, `in_stride` bytes apart; `out` gets n * width bytes.
void Shuffle(const char* in, size_t n, size_t width, size_t in_stride, char* out);

// The inverse; writes values `out_stride` bytes apart and nothing between them.
void Unshuffle(const char* in, size_t n, size_t width, char* out, size_t out_stride);

}  // namespace isthmus::codec
