#include "core/codec/quantized_columns.h"

#include <absl/strings/str_cat.h>

#include "core/codec/payload_layout.h"
#include "core/codec/quantized.h"

namespace isthmus::codec {
namespace {

bool IsCoordinate(const PointPayload& payload, const PointField& field) {
  const bool floating = field.type == ScalarType::kFloat32 || field.type == ScalarType::kFloat64;
  return floating && field.count == 1 &&
         (&field == FindField(payload, {"x"}) || &field == FindField(payload, {"y"}) ||
          &field == FindField(payload, {"z"}));
}

}  // namespace

absl::Status CheckRounded(const PointPayload& payload, double resolution_m) {
  if (!(resolution_m >= kMinResolutionM && resolution_m <= kMaxResolutionM)) {
    return absl::InvalidArgumentError(absl::StrCat("the resolution must be ", kMinResolutionM,
                                                   " to ", kMaxResolutionM, " m; it is ",
                                                   resolution_m));
  }
  if (absl::Status status = CheckLayout(payload); !status.ok()) return status;
  for (const char* name : {"x", "y", "z"}) {
    if (FindField(payload, {name}) == nullptr) {
      return absl::InvalidArgumentError(absl::StrCat("the cloud has no field '", name, "'"));
    }
  }
  return absl::OkStatus();
}

absl::Status CoordinateTooFar(double resolution_m) {
  return absl::InvalidArgumentError(
      absl::StrCat("a coordinate is beyond ", kMaxDeltaCodeValue * resolution_m,
                   " m, the farthest that a step of ", resolution_m, " m allows"));
}

absl::StatusOr<std::vector<Column>> ListColumns(const PointPayload& payload) {
  std::vector<Column> columns;
  uint64_t bytes = 0;
  for (const PointField& field : payload.fields) {
    bytes += PointCount(payload) * field.count * SizeOf(field.type);
    if (bytes > kMaxDecodedBytes || columns.size() + field.count > kMaxStride) {
      return absl::InvalidArgumentError("the fields overlap and need too much memory");
    }
    for (uint32_t k = 0; k < field.count; ++k) {
      columns.push_back(
          {field.offset + k * SizeOf(field.type), field.type, IsCoordinate(payload, field)});
    }
  }
  return columns;
}

}  // namespace isthmus::codec
