// A hash of content that is the same in every process and on every machine of the same endianness.
//
// For telling apart what was not made to collide: caches and versions, never trust.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace isthmus {

// Depends on everything added, and on the order. Value type.
class ContentHash {
 public:
  void Add(uint64_t word) {
    // Both halves of a product that is not cut off, so that every bit of the sum moves all others.
    const Product product = static_cast<Product>(state_ ^ word) * kMultiplier;
    state_ = static_cast<uint64_t>(product) ^ static_cast<uint64_t>(product >> 64) ^ kOffset;
  }
  // The bytes as they lie in memory, and how many.
  void AddBytes(const void* data, size_t size) {
    Add(size);
    const auto* bytes = static_cast<const char*>(data);
    while (size > 0) {
      const size_t part = size < sizeof(uint64_t) ? size : sizeof(uint64_t);
      uint64_t word = 0;
      std::memcpy(&word, bytes, part);
      Add(word);
      bytes += part;
      size -= part;
    }
  }
  void AddText(std::string_view text) { AddBytes(text.data(), text.size()); }

  uint64_t value() const { return state_; }

 private:
  __extension__ using Product = unsigned __int128;

  // The fractions of the golden ratio and of the square root of two; the first is odd.
  static constexpr uint64_t kMultiplier = 0x9e3779b97f4a7c15;  // Math
  static constexpr uint64_t kOffset = 0x6a09e667f3bcc908;      // Math

  uint64_t state_ = kOffset;
};

}  // namespace isthmus
