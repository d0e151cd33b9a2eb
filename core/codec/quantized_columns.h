// The columns of a quantised payload, the checks of payloads that are rounded, and the rounding of
// coordinates to steps.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/codec/delta_code.h"
#include "core/point_payload.h"

namespace isthmus::codec {

inline constexpr size_t kQuantizedHeaderSize = 8;  // Magic, version, a zero, checksum.

// InvalidArgument for a resolution out of range, a bad layout (see CheckLayout), or no x y z.
absl::Status CheckRounded(const PointPayload& payload, double resolution_m);

// One value per point: a field, or one element of a field with count > 1.
struct Column {
  uint32_t offset = 0;
  ScalarType type = ScalarType::kFloat32;
  bool is_coordinate = false;
};

// Columns in the order of fields, and of elements within a field. InvalidArgument when they need
// more than kMaxDecodedBytes, which only overlapping fields do once the layout was checked.
absl::StatusOr<std::vector<Column>> ListColumns(const PointPayload& payload);

// The outcome of rounding a coordinate.
enum class Rounded : uint8_t { kSteps, kNoValue, kTooFar };

// To the nearest whole number of steps, halves away from zero; `scale` is 1 / step.
template <typename T>
Rounded RoundToSteps(T value, double scale, int32_t* steps) {
  const double exact = static_cast<double>(value) * scale;
  if (!std::isfinite(exact)) return Rounded::kNoValue;
  if (!(std::abs(exact) < kMaxDeltaCodeValue)) return Rounded::kTooFar;
  *steps = static_cast<int32_t>(exact + std::copysign(0.5, exact));
  return Rounded::kSteps;
}

// The error for kTooFar.
absl::Status CoordinateTooFar(double resolution_m);

}  // namespace isthmus::codec
