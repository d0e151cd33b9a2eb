// Numbers of a few bits each, packed one behind the other, the lowest bit first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

namespace isthmus::codec {

class BitWriter {
 public:
  // At most 32 bits; those of `value` above them must be 0.
  void Write(uint32_t value, int bits) {
    word_ |= uint64_t{value} << used_;
    used_ += bits;
    if (used_ < 32) return;
    const auto low = static_cast<uint32_t>(word_);
    bytes_.append(reinterpret_cast<const char*>(&low), sizeof(low));
    word_ >>= 32;
    used_ -= 32;
  }

  // All bytes; the last one is filled up with zeros.
  std::string Finish() {
    for (; used_ > 0; used_ -= 8, word_ >>= 8) bytes_.push_back(static_cast<char>(word_));
    used_ = 0;
    return std::move(bytes_);
  }

 private:
  std::string bytes_;
  uint64_t word_ = 0;
  int used_ = 0;
};

// Behind the end it reads zeros, and says so afterwards.
class BitReader {
 public:
  BitReader(const char* bytes, size_t size)
      : next_(reinterpret_cast<const uint8_t*>(bytes)), end_(next_ + size) {}

  // At most 32 bits.
  uint32_t Read(int bits) {
    for (; have_ < bits; have_ += 8) {
      if (next_ == end_) {
        past_end_ = true;
      } else {
        word_ |= uint64_t{*next_++} << have_;
      }
    }
    const auto value = static_cast<uint32_t>(word_ & ((uint64_t{1} << bits) - 1));
    word_ >>= bits;
    have_ -= bits;
    return value;
  }

  // True if nothing was missing and nothing but the filling of the last byte is left.
  bool complete() const { return !past_end_ && next_ == end_ && have_ < 8 && word_ == 0; }

 private:
  const uint8_t* next_;
  const uint8_t* end_;
  uint64_t word_ = 0;
  int have_ = 0;
  bool past_end_ = false;
};

}  // namespace isthmus::codec
