// Lossless ways to lay out a column of numbers so that a general compressor finds what repeats.
#pragma once

#include <cstddef>
#include <string>

namespace isthmus::codec {

// Stored; the numbers must not change. See docs/storage-format.md, "Quantised payload".
enum class Transform : char {
  kPlain = 0,       // Byte planes of the values.
  kDelta = 1,       // Byte planes of each value's difference to the one before, as whole numbers.
  kCoordinate = 2,  // Byte planes of delta codes (delta_code.h) of 4 bytes.
  kPalette = 3,     // 256 values, then one byte per point that picks one.
  kRay = 4,         // Elsewhere: a coordinate that follows from rays (ray_code.h).
};

// True for those that EncodeColumn makes.
inline bool IsLossless(Transform transform) {
  return transform == Transform::kPlain || transform == Transform::kDelta ||
         transform == Transform::kPalette;
}

// Bytes of n values of `width` bytes (1, 2, 4 or 8) after the transform.
size_t EncodedSize(Transform transform, size_t width, size_t n);

// Appends n values, which lie `stride` bytes apart, by the transform that promises most: kDelta
// for rings and times, kPalette for intensities of at most 256 levels, else kPlain.
Transform EncodeColumn(const char* in, size_t stride, size_t n, size_t width, std::string& out);

// The inverse, for those of IsLossless. Any bytes are taken; damaged ones give wrong values.
void DecodeColumn(Transform transform, const char* in, size_t n, size_t width, char* out,
                  size_t stride);

}  // namespace isthmus::codec
