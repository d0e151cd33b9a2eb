// The numbers, strings and arrays of a serialised message, one after the other.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace isthmus::readers {

// Reads never go beyond the end: once one would, ok() is false and zeros are read.
//
// Plain: ROS 1 serialisation (wiki.ros.org/roscpp/Overview/MessagesSerializationAndAdaptingTypes)
// and MCAP's: little endian, packed, strings and arrays behind a uint32 of their length.
// CDR: "DDS-XTypes 1.3", OMG, sections 7.4.1 and 7.6.3.1, of representation 1 (PLAIN_CDR): numbers
// are aligned to their size, counted from behind the four bytes that come first, and strings end
// with a zero byte.
class FieldReader {
 public:
  static FieldReader Plain(absl::string_view bytes) { return FieldReader(bytes, false, false); }
  // InvalidArgument for other representations, naming the one it is.
  static absl::StatusOr<FieldReader> Cdr(absl::string_view bytes);

  template <typename T>
  T Read() {
    if (aligned_) Skip((sizeof(T) - at_ % sizeof(T)) % sizeof(T));
    char bytes[sizeof(T)] = {};
    const absl::string_view there = ReadBytes(sizeof(T));
    if (ok_) std::memcpy(bytes, there.data(), sizeof(T));
    if (swapped_) std::reverse(bytes, bytes + sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
  }
  absl::string_view ReadString();
  // The length of an array whose elements take so many bytes at least; 0, and ok() false, where
  // fewer are left than that many take.
  uint32_t ReadCount(size_t least_bytes);
  absl::string_view ReadBytes(size_t size);
  void Skip(size_t size) { ReadBytes(size); }

  bool ok() const { return ok_; }
  bool is_cdr() const { return aligned_; }
  size_t remaining() const { return bytes_.size() - at_; }

 private:
  FieldReader(absl::string_view bytes, bool aligned, bool swapped)
      : bytes_(bytes), aligned_(aligned), swapped_(swapped) {}

  absl::string_view bytes_;
  size_t at_ = 0;
  bool aligned_, swapped_;
  bool ok_ = true;
};

}  // namespace isthmus::readers
