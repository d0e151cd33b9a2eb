#include "core/codec/byte_shuffle.h"

#include <cstdint>

#include "core/codec/byte_planes.h"

namespace isthmus::codec {
namespace {

template <typename Word>
void ShuffleWords(const char* in, size_t n, size_t in_stride, char* out) {
  for (size_t i = 0; i < n; ++i) StorePlanes(LoadAs<Word>(in + i * in_stride), out, n, i);
}

template <typename Word>
void UnshuffleWords(const char* in, size_t n, char* out, size_t out_stride) {
  for (size_t i = 0; i < n; ++i) StoreAs(LoadPlanes<Word>(in, n, i), out + i * out_stride);
}

}  // namespace

void Shuffle(const char* in, size_t n, size_t width, size_t in_stride, char* out) {
  VisitWord(width, [&](auto zero) { ShuffleWords<decltype(zero)>(in, n, in_stride, out); });
}

void Unshuffle(const char* in, size_t n, size_t width, char* out, size_t out_stride) {
  VisitWord(width, [&](auto zero) { UnshuffleWords<decltype(zero)>(in, n, out, out_stride); });
}

}  // namespace isthmus::codec
