// Records as bytes, by one list of their fields for both ways: Fields(stream, record), found where
// the record's own stands, calls stream(field, ...).
#pragma once

#include <Eigen/Core>
#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "core/byte_stream.h"
#include "core/ids.h"
#include "core/pose.h"
#include "storage/records/pose_codec.h"

namespace isthmus::server {

template <typename Record, typename Wanted>
concept Is = std::same_as<std::remove_const_t<Record>, Wanted>;

template <typename T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

class RecordWriter {
 public:
  template <typename... Ts>
  void operator()(const Ts&... fields) {
    (Put(fields), ...);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  template <Number T>
  void Put(const T& value) {
    AppendBytes(value, bytes_);
  }
  void Put(const std::string& text) {
    AppendBytes(static_cast<uint32_t>(text.size()), bytes_);
    bytes_ += text;
  }
  template <typename Tag>
  void Put(const TextId<Tag>& id) {
    Put(id.value());
  }
  void Put(const Pose& pose) { storage::AppendPose(pose, bytes_); }
  void Put(const Matrix6d& matrix) {
    for (int i = 0; i < matrix.size(); ++i) AppendBytes(matrix.data()[i], bytes_);
  }
  template <typename T>
  void Put(const std::vector<T>& values) {
    AppendBytes(static_cast<uint32_t>(values.size()), bytes_);
    for (const T& value : values) Put(value);
  }
  template <typename T>
  void Put(const std::optional<T>& value) {
    Put(value.has_value());
    if (value) Put(*value);
  }
  template <typename T>
  void Put(const T& record) {
    Fields(*this, record);
  }

  std::string bytes_;
};

// Of bytes that are no such record something comes out, and ok() is false. Takes no more memory
// than the bytes justify.
class RecordReader {
 public:
  explicit RecordReader(const std::string& bytes) : bytes_(bytes) {}

  template <typename... Ts>
  void operator()(Ts&... fields) {
    (Get(fields), ...);
  }
  // All was there, and nothing behind it.
  bool ok() const { return bytes_.ok() && bytes_.remaining() == 0; }

 private:
  template <Number T>
  void Get(T& value) {
    value = bytes_.Read<T>();
  }
  void Get(bool& value) { value = bytes_.Read<uint8_t>() != 0; }
  void Get(std::string& text) { text = bytes_.ReadString(bytes_.Read<uint32_t>()); }
  template <typename Tag>
  void Get(TextId<Tag>& id) {
    std::string text;
    Get(text);
    id = TextId<Tag>(std::move(text));
  }
  void Get(Pose& pose) { pose = storage::ReadPose(bytes_); }
  void Get(Matrix6d& matrix) {
    for (int i = 0; i < matrix.size(); ++i) matrix.data()[i] = bytes_.Read<double>();
  }
  template <typename T>
  void Get(std::vector<T>& values) {
    values.clear();
    const auto count = bytes_.Read<uint32_t>();
    for (uint32_t i = 0; i < count && bytes_.ok(); ++i) Get(values.emplace_back());
  }
  template <typename T>
  void Get(std::optional<T>& value) {
    bool is_there = false;
    Get(is_there);
    value.reset();
    if (is_there) Get(value.emplace());
  }
  template <typename T>
  void Get(T& record) {
    Fields(*this, record);
  }

  ByteReader bytes_;
};

}  // namespace isthmus::server
