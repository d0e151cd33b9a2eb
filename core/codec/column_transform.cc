#include "core/codec/column_transform.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/codec/byte_planes.h"
#include "core/codec/byte_shuffle.h"
#include "core/codec/column.h"

namespace isthmus::codec {
namespace {

constexpr size_t kPaletteSize = 256;

template <typename Word>
std::vector<Word> Gather(const char* in, size_t stride, size_t n) {
  std::vector<Word> values(n);
  for (size_t i = 0; i < n; ++i) values[i] = LoadAs<Word>(in + i * stride);
  return values;
}

template <typename Word>
void AppendPlanes(const std::vector<Word>& values, std::string& out) {
  const size_t start = out.size();
  out.resize(start + values.size() * sizeof(Word));
  Shuffle(reinterpret_cast<const char*>(values.data()), values.size(), sizeof(Word), sizeof(Word),
          out.data() + start);
}

// True if neighbouring differences share more bytes than neighbouring values, in a sample from the
// middle of the cloud.
template <typename Word>
bool DeltaPacksBetter(const std::vector<Word>& values) {
  const size_t sample = std::min<size_t>(values.size(), 2048);
  const size_t begin = (values.size() - sample) / 2;
  size_t plain_changes = 0, delta_changes = 0;
  Word last = 0, last_delta = 0;
  for (size_t i = begin; i < begin + sample; ++i) {
    const auto delta = static_cast<Word>(values[i] - last);
    for (size_t shift = 0; shift < 8 * sizeof(Word); shift += 8) {
      plain_changes += (((values[i] ^ last) >> shift) & 0xFF) != 0;
      delta_changes += (((delta ^ last_delta) >> shift) & 0xFF) != 0;
    }
    last = values[i];
    last_delta = delta;
  }
  return delta_changes * 10 < plain_changes * 9;
}

template <typename Word>
void TakeDifferences(std::vector<Word>& values) {
  Word last = 0;
  for (Word& value : values) {
    const Word current = value;
    value = static_cast<Word>(current - last);
    last = current;
  }
}

// Appends the palette, in order of first appearance, and the indices. False, and nothing appended,
// when there are more values than a palette holds.
template <typename Word>
bool AppendPalette(const std::vector<Word>& values, std::string& out) {
  constexpr size_t kSlotBits = 11;
  constexpr int kFree = -1;
  std::array<int, size_t{1} << kSlotBits> slots;  // Open addressing: indices into the palette.
  slots.fill(kFree);
  std::vector<Word> palette;
  std::string indices(values.size(), '\0');
  for (size_t i = 0; i < values.size(); ++i) {
    constexpr uint64_t kGoldenRatio = 0x9E3779B97F4A7C15;  // Fibonacci hashing.
    size_t slot = (uint64_t{values[i]} * kGoldenRatio) >> (64 - kSlotBits);
    while (slots[slot] != kFree && palette[slots[slot]] != values[i]) {
      slot = (slot + 1) % slots.size();
    }
    if (slots[slot] == kFree) {
      if (palette.size() == kPaletteSize) return false;
      slots[slot] = static_cast<int>(palette.size());
      palette.push_back(values[i]);
    }
    indices[i] = static_cast<char>(slots[slot]);
  }
  palette.resize(kPaletteSize);
  out.append(reinterpret_cast<const char*>(palette.data()), kPaletteSize * sizeof(Word));
  out += indices;
  return true;
}

template <typename Word>
Transform Encode(std::vector<Word> values, std::string& out) {
  if (DeltaPacksBetter(values)) {
    TakeDifferences(values);
    AppendPlanes(values, out);
    return Transform::kDelta;
  }
  const size_t n = values.size();
  const bool worth_it = EncodedSize(Transform::kPalette, sizeof(Word), n) < n * sizeof(Word);
  if (worth_it && AppendPalette(values, out)) return Transform::kPalette;
  AppendPlanes(values, out);
  return Transform::kPlain;
}

}  // namespace

size_t EncodedSize(Transform transform, size_t width, size_t n) {
  if (transform == Transform::kPalette) return kPaletteSize * width + n;
  return n * (transform == Transform::kCoordinate ? sizeof(uint32_t) : width);
}

Transform EncodeColumn(const char* in, size_t stride, size_t n, size_t width, std::string& out) {
  return VisitWord(width,
                   [&](auto zero) { return Encode(Gather<decltype(zero)>(in, stride, n), out); });
}

void DecodeColumn(Transform transform, const char* in, size_t n, size_t width, char* out,
                  size_t stride) {
  if (transform == Transform::kPlain) return Unshuffle(in, n, width, out, stride);
  VisitWord(width, [&](auto sum) {
    using Word = decltype(sum);
    if (transform == Transform::kDelta) {
      for (size_t i = 0; i < n; ++i) {
        sum = static_cast<Word>(sum + LoadPlanes<Word>(in, n, i));
        StoreAs(sum, out + i * stride);
      }
    } else if (transform == Transform::kPalette) {
      const auto* indices = reinterpret_cast<const unsigned char*>(in) + kPaletteSize * width;
      for (size_t i = 0; i < n; ++i) {
        StoreAs(LoadAs<Word>(in + indices[i] * width), out + i * stride);
      }
    }
  });
}

}  // namespace isthmus::codec
