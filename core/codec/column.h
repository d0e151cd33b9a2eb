// Typed access to the columns of a raw payload: the one place that knows how bytes become numbers.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

#include "core/codec/payload_layout.h"
#include "core/point_payload.h"

namespace isthmus::codec {

// Records are little endian and copied as they are.
static_assert(std::endian::native == std::endian::little);

template <typename T>
T LoadAs(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

template <typename T>
void StoreAs(T value, char* bytes) {
  std::memcpy(bytes, &value, sizeof(T));
}

// Calls `visitor` with a value of the C++ type that `type` stands for; returns what it returns.
template <typename Visitor>
auto VisitScalar(ScalarType type, const Visitor& visitor) {
  switch (type) {
    case ScalarType::kInt8:
      return visitor(int8_t{});
    case ScalarType::kUint8:
      return visitor(uint8_t{});
    case ScalarType::kInt16:
      return visitor(int16_t{});
    case ScalarType::kUint16:
      return visitor(uint16_t{});
    case ScalarType::kInt32:
      return visitor(int32_t{});
    case ScalarType::kUint32:
      return visitor(uint32_t{});
    case ScalarType::kFloat32:
      return visitor(float{});
    case ScalarType::kFloat64:
      break;
  }
  return visitor(double{});
}

// Calls `visitor(i, value)` with the first value of `field` for every point, in its own type. The
// payload's layout was checked.
template <typename Visitor>
void ForEachValue(const PointPayload& raw, const PointField& field, const Visitor& visitor) {
  const uint64_t n = PointCount(raw);
  const char* in = raw.data.data() + field.offset;
  VisitScalar(field.type, [&](auto scalar) {
    for (uint64_t i = 0; i < n; ++i) visitor(i, LoadAs<decltype(scalar)>(in + i * raw.stride));
  });
}

}  // namespace isthmus::codec
