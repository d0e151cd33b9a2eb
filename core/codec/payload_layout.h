// The layout of a point payload: the checks that come first, and how fields are found and read.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

#include "core/point_payload.h"

namespace isthmus::codec {

// Limits that hold whatever a header claims, so that a lying one cannot exhaust memory.
inline constexpr uint64_t kMaxScanPoints = 4'000'000;
inline constexpr uint64_t kMaxDecodedBytes = 256u << 20;
inline constexpr uint32_t kMaxStride = 65536;
inline constexpr size_t kMaxFields = 128;

// Points of the payload; no overflow.
inline uint64_t PointCount(const PointPayload& payload) {
  return uint64_t{payload.width} * payload.height;
}

// InvalidArgument unless width * height is within [1, kMaxScanPoints], every field lies within the
// stride, the decoded size is within kMaxDecodedBytes and, for a raw payload, is the size of
// `data`.
absl::Status CheckLayout(const PointPayload& payload);

// As CheckLayout, for clouds that are files or whole maps: no limit but the size of the data.
absl::Status CheckRawLayout(const PointPayload& payload);

// The first field with one of these names, in the order of names, whatever the case of its letters;
// null if there is none.
const PointField* FindField(const PointPayload& payload, std::initializer_list<const char*> names);
// The same by all names under which drivers write rings, and times of any unit.
const PointField* FindRingField(const PointPayload& payload);
const PointField* FindPlainTimeField(const PointPayload& payload);

// The (first) value of a field for every point of a raw payload whose layout was checked.
std::vector<double> ReadColumn(const PointPayload& raw, const PointField& field);

// "float32", "uint16", ...
const char* ToString(ScalarType type);

}  // namespace isthmus::codec
