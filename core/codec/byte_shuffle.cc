#include "core/codec/byte_shuffle.h"

namespace isthmus::codec {

void Shuffle(const char* in, size_t n, size_t width, size_t in_stride, char* out) {
  for (size_t byte = 0; byte < width; ++byte) {
    for (size_t i = 0; i < n; ++i) out[i] = in[i * in_stride + byte];
    out += n;
  }
}

void Unshuffle(const char* in, size_t n, size_t width, char* out, size_t out_stride) {
  for (size_t byte = 0; byte < width; ++byte) {
    for (size_t i = 0; i < n; ++i) out[i * out_stride + byte] = in[i];
    in += n;
  }
}

}  // namespace isthmus::codec
