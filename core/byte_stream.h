// Little-endian numbers one after the other.
#pragma once

#include <bit>
#include <cstddef>
#include <cstring>
#include <string>

namespace isthmus {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

template <typename T>
void AppendBytes(T value, std::string& out) {
  out.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

// Reads never go beyond the end; once one would, ok() is false and zeros are read.
class ByteReader {
 public:
  explicit ByteReader(const std::string& bytes) : bytes_(bytes) {}

  template <typename T>
  T Read() {
    T value{};
    ok_ = ok_ && bytes_.size() - at_ >= sizeof(T);
    if (!ok_) return value;
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }

  // Empty, and ok() false, where there are fewer bytes left.
  std::string ReadString(size_t size) {
    ok_ = ok_ && remaining() >= size;
    if (!ok_) return {};
    at_ += size;
    return bytes_.substr(at_ - size, size);
  }

  // The next `size` bytes; null, and ok() false, if there are fewer.
  const char* ReadBytes(size_t size) {
    ok_ = ok_ && remaining() >= size;
    if (!ok_) return nullptr;
    at_ += size;
    return bytes_.data() + at_ - size;
  }

  bool ok() const { return ok_; }
  // The bytes that have not been read.
  std::string Rest() const { return bytes_.substr(at_); }
  size_t remaining() const { return bytes_.size() - at_; }

 private:
  const std::string& bytes_;
  size_t at_ = 0;
  bool ok_ = true;
};

}  // namespace isthmus
