// The codec that turns the state of a class, or a record, into bytes and back: every float and
// double bit for bit.
//
// A class lists what later results depend on, once, in a template that serves both ways:
//
//   template <typename Self, typename Io>
//   static void Fields(Self& self, Io& io) { io(self.scans_, self.T_odom_last_); }
//
// or, for a record that knows nothing of this, a function in its namespace does (IsRecord):
//
//   void Fields(IsRecord<Keyframe> auto& self, auto& io) { io(self.sequence, self.stamp_ns); }
//
// `Self` is const when the state is written. Bytes are little-endian, without padding; containers
// begin with their size as uint64.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/ids.h"
#include "core/pose.h"

namespace isthmus {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

// Tells damage from what was written; no protection against malice. Eight bytes at a time, FNV-1a
// with the finaliser of SplitMix64.
uint64_t StateChecksum(const char* data, size_t size);

namespace internal {
template <typename T>
inline constexpr bool kIsNumber = std::is_arithmetic_v<T> || std::is_enum_v<T>;
template <typename T>
inline constexpr bool kIsMatrix = std::is_base_of_v<Eigen::PlainObjectBase<T>, T>;
}  // namespace internal

template <typename T, typename Record>
concept IsRecord = std::same_as<std::remove_const_t<T>, Record>;

void Fields(IsRecord<SubmapId> auto& id, auto& io) { io(id.session, id.index); }

class StateWriter {
 public:
  static constexpr bool kIsReading = false;

  template <typename... T>
  void operator()(const T&... values) {
    (Write(values), ...);
  }
  void Raw(const void* data, size_t size) { bytes_.append(static_cast<const char*>(data), size); }

  void Reserve(size_t size) { bytes_.reserve(size); }
  std::string Take() { return std::move(bytes_); }

 private:
  template <typename T>
  void Write(const T& value) {
    if constexpr (internal::kIsNumber<T>) {
      Raw(&value, sizeof(T));
    } else if constexpr (internal::kIsMatrix<T>) {
      Raw(value.data(), sizeof(typename T::Scalar) * static_cast<size_t>(value.size()));
    } else if constexpr (requires { T::Fields(value, *this); }) {
      T::Fields(value, *this);
    } else {
      Fields(value, *this);
    }
  }
  void Write(const Pose& pose) {
    Write(pose.rotation().coeffs());
    Write(pose.translation());
  }
  void Write(const std::string& text) {
    Write(uint64_t{text.size()});
    Raw(text.data(), text.size());
  }
  template <typename Tag>
  void Write(const TextId<Tag>& id) {
    Write(id.value());
  }
  template <typename T>
  void Write(const std::optional<T>& value) {
    Write(value.has_value());
    if (value) Write(*value);
  }
  template <typename T, size_t n>
  void Write(const std::array<T, n>& values) {
    for (const T& value : values) Write(value);
  }
  template <typename T>
  void Write(const std::vector<T>& values) {
    Write(uint64_t{values.size()});
    if constexpr (internal::kIsNumber<T>) {
      Raw(values.data(), values.size() * sizeof(T));
    } else {
      for (const T& value : values) Write(value);
    }
  }

  template <typename Key, typename Value>
  void Write(const std::map<Key, Value>& values) {
    Write(uint64_t{values.size()});
    for (const auto& [key, value] : values) (*this)(key, value);
  }

  std::string bytes_;
};

// Reads never go beyond the end, and never set aside more memory than a small multiple of what is
// left to read. Once something is amiss ok() is false and what is read is zero.
class StateReader {
 public:
  static constexpr bool kIsReading = true;

  // Keeps pointing there.
  StateReader(const char* data, size_t size) : at_(data), end_(data + size) {}

  template <typename... T>
  void operator()(T&... values) {
    (Read(values), ...);
  }
  void Raw(void* data, size_t size) {
    if (size == 0) return;  // `data` may be null then.
    if (size > remaining()) Expect(false);
    if (!ok_) {
      std::memset(data, 0, size);
      return;
    }
    std::memcpy(data, at_, size);
    at_ += size;
  }
  // The number of elements to come, each of which takes that many bytes at least; else not ok.
  size_t Count(size_t least_size) {
    uint64_t count = 0;
    Read(count);
    Expect(count <= remaining() / least_size);
    return ok_ ? static_cast<size_t>(count) : 0;
  }
  // A condition that the values read must satisfy.
  void Expect(bool holds) { ok_ = ok_ && holds; }

  bool ok() const { return ok_; }
  size_t remaining() const { return static_cast<size_t>(end_ - at_); }

 private:
  template <typename T>
  void Read(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      uint8_t byte = 0;
      Raw(&byte, 1);
      Expect(byte <= 1);
      value = ok_ && byte == 1;
    } else if constexpr (internal::kIsNumber<T>) {
      Raw(&value, sizeof(T));
    } else if constexpr (internal::kIsMatrix<T>) {
      Raw(value.data(), sizeof(typename T::Scalar) * static_cast<size_t>(value.size()));
    } else if constexpr (requires { T::Fields(value, *this); }) {
      T::Fields(value, *this);
    } else {
      Fields(value, *this);
    }
  }
  // Pose's constructor would normalise the quaternion anew, which may change its last bits.
  void Read(Pose& pose) {
    Eigen::Vector4d coefficients;
    Read(coefficients);
    Expect(std::abs(coefficients.squaredNorm() - 1) < 1e-9);
    const_cast<Eigen::Quaterniond&>(pose.rotation()).coeffs() =
        ok_ ? coefficients : Eigen::Vector4d(Eigen::Quaterniond::Identity().coeffs());
    Read(const_cast<Eigen::Vector3d&>(pose.translation()));
    Expect(pose.IsFinite());
  }
  void Read(std::string& text) {
    text.resize(Count(1));
    Raw(text.data(), text.size());
  }
  template <typename Tag>
  void Read(TextId<Tag>& id) {
    std::string text;
    Read(text);
    id = TextId<Tag>(std::move(text));
  }
  template <typename T>
  void Read(std::optional<T>& value) {
    bool has_value = false;
    Read(has_value);
    value.reset();
    if (has_value) Read(value.emplace());
  }
  template <typename T, size_t n>
  void Read(std::array<T, n>& values) {
    for (T& value : values) Read(value);
  }
  template <typename T>
  void Read(std::vector<T>& values) {
    values.clear();
    if constexpr (internal::kIsNumber<T>) {
      values.resize(Count(sizeof(T)));
      Raw(values.data(), values.size() * sizeof(T));
    } else {
      for (size_t left = Count(1); left > 0 && ok_; --left) Read(values.emplace_back());
    }
  }
  template <typename Key, typename Value>
  void Read(std::map<Key, Value>& values) {
    values.clear();
    for (size_t left = Count(1); left > 0 && ok_; --left) {
      Key key;
      Read(key);
      Read(values[key]);
    }
  }

  const char* at_;
  const char* const end_;
  bool ok_ = true;
};

// The bytes with what they are, of which version and a checksum around them; `options` is a
// checksum over what they were made with. `magic` has four characters.
std::string SealState(const char* magic, uint32_t version, uint64_t options, std::string state);

// The state that was sealed. InvalidArgument where it is of another version or was made with other
// options, DataLoss for all that SealState did not make; `name` says in the message what it is of.
absl::StatusOr<StateReader> OpenState(const char* magic, uint32_t version, uint64_t options,
                                      const std::string& sealed, const std::string& name);

}  // namespace isthmus
