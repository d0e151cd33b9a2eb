#include "core/codec/quantized_columns.h"

#include "core/codec/payload_layout.h"

namespace isthmus::codec {
namespace {

bool IsCoordinate(const PointPayload& payload, const PointField& field) {
  const bool floating = field.type == ScalarType::kFloat32 || field.type == ScalarType::kFloat64;
  return floating && field.count == 1 &&
         (&field == FindField(payload, {"x"}) || &field == FindField(payload, {"y"}) ||
          &field == FindField(payload, {"z"}));
}

}  // namespace

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
