#include "core/codec/quantized.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/codec/byte_shuffle.h"
#include "core/codec/column.h"
#include "core/codec/column_transform.h"
#include "core/codec/delta_code.h"
#include "core/codec/payload_layout.h"
#include "core/codec/zstd_frame.h"
#include "core/io/crc32c.h"

namespace isthmus::codec {
namespace {

constexpr char kMagic[3] = {'I', 'Q', 1};  // The last byte is the version.
constexpr size_t kHeaderSize = 8;          // Magic, a zero, checksum.

// One value per point: a field, or one element of a field with count > 1.
struct Column {
  uint32_t offset = 0;
  ScalarType type = ScalarType::kFloat32;
  bool is_coordinate = false;
};

bool IsCoordinate(const PointPayload& payload, const PointField& field) {
  const bool floating = field.type == ScalarType::kFloat32 || field.type == ScalarType::kFloat64;
  return floating && field.count == 1 &&
         (&field == FindField(payload, {"x"}) || &field == FindField(payload, {"y"}) ||
          &field == FindField(payload, {"z"}));
}

// Columns in the order of fields, and of elements within a field. InvalidArgument when they need
// more than kMaxDecodedBytes, which only overlapping fields do once the layout was checked.
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

absl::Status Check(const PointPayload& payload, double resolution_m) {
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

// False when a coordinate is out of range.
template <typename T>
bool QuantizeColumn(const char* in, uint32_t stride, size_t n, double resolution_m,
                    std::vector<uint32_t>& codes) {
  const double scale = 1.0 / resolution_m;
  DeltaEncoder encoder;
  bool in_range = true;
  for (size_t i = 0; i < n; ++i) {
    const double steps = static_cast<double>(LoadAs<T>(in + i * stride)) * scale;
    if (!std::isfinite(steps)) {
      codes[i] = kNoValueCode;
    } else if (std::abs(steps) < kMaxDeltaCodeValue) {
      codes[i] = encoder.Encode(static_cast<int32_t>(steps + std::copysign(0.5, steps)));
    } else {
      in_range = false;
    }
  }
  return in_range;
}

template <typename T>
void DequantizeColumn(const std::vector<uint32_t>& codes, double resolution_m, char* out,
                      uint32_t stride) {
  DeltaDecoder decoder;
  for (size_t i = 0; i < codes.size(); ++i) {
    T value = std::numeric_limits<T>::quiet_NaN();
    if (codes[i] != kNoValueCode) value = static_cast<T>(decoder.Decode(codes[i]) * resolution_m);
    StoreAs(value, out + i * stride);
  }
}

absl::Status EncodeCoordinate(const PointPayload& raw, const Column& column, double resolution_m,
                              std::string& out) {
  const char* in = raw.data.data() + column.offset;
  const size_t n = PointCount(raw);
  std::vector<uint32_t> codes(n);
  const bool in_range = column.type == ScalarType::kFloat32
                            ? QuantizeColumn<float>(in, raw.stride, n, resolution_m, codes)
                            : QuantizeColumn<double>(in, raw.stride, n, resolution_m, codes);
  if (!in_range) {
    return absl::InvalidArgumentError(
        absl::StrCat("a coordinate is beyond ", kMaxDeltaCodeValue * resolution_m,
                     " m, the farthest that a step of ", resolution_m, " m allows"));
  }
  const size_t start = out.size();
  out.resize(start + n * sizeof(uint32_t));
  Shuffle(reinterpret_cast<const char*>(codes.data()), n, 4, 4, out.data() + start);
  return absl::OkStatus();
}

void DecodeCoordinate(const char* in, const Column& column, double resolution_m,
                      PointPayload& raw) {
  std::vector<uint32_t> codes(PointCount(raw));
  Unshuffle(in, codes.size(), 4, reinterpret_cast<char*>(codes.data()), 4);
  char* out = raw.data.data() + column.offset;
  if (column.type == ScalarType::kFloat32) {
    DequantizeColumn<float>(codes, resolution_m, out, raw.stride);
  } else {
    DequantizeColumn<double>(codes, resolution_m, out, raw.stride);
  }
}

Transform TransformOf(const PointPayload& quantized, size_t column) {
  return static_cast<Transform>(quantized.data[kHeaderSize + column]);
}

// Everything before the zstd frame.
absl::Status CheckHeader(const PointPayload& quantized, const std::vector<Column>& columns) {
  const std::string& data = quantized.data;
  if (data.size() <= kHeaderSize + columns.size() || data[0] != kMagic[0] || data[1] != kMagic[1]) {
    return absl::InvalidArgumentError("the data is not a quantised payload of these fields");
  }
  if (data[2] != kMagic[2] || data[3] != 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("quantised payload of version ", static_cast<int>(data[2]),
                     "; this program reads version ", static_cast<int>(kMagic[2])));
  }
  if (LoadAs<uint32_t>(&data[4]) != io::Crc32c(&data[kHeaderSize], data.size() - kHeaderSize)) {
    return absl::InvalidArgumentError("the checksum of the quantised payload is wrong");
  }
  for (size_t c = 0; c < columns.size(); ++c) {
    const Transform transform = TransformOf(quantized, c);
    const bool known = transform >= Transform::kPlain && transform <= Transform::kPalette;
    if (!known || (transform == Transform::kCoordinate) != columns[c].is_coordinate) {
      return absl::InvalidArgumentError("the fields do not fit the quantised payload");
    }
  }
  return absl::OkStatus();
}

// The zstd frame's content, once the header has been checked.
absl::StatusOr<std::string> OpenFrame(const PointPayload& quantized,
                                      const std::vector<Column>& columns) {
  size_t size = 0;
  for (size_t c = 0; c < columns.size(); ++c) {
    size += EncodedSize(TransformOf(quantized, c), SizeOf(columns[c].type), PointCount(quantized));
  }
  if (size > kMaxDecodedBytes) {
    return absl::InvalidArgumentError("the quantised payload needs too much memory");
  }
  const size_t start = kHeaderSize + columns.size();
  return ReadZstdFrame(&quantized.data[start], quantized.data.size() - start, size);
}

}  // namespace

absl::StatusOr<PointPayload> Quantize(const PointPayload& raw, double resolution_m) {
  if (raw.encoding != PayloadEncoding::kRaw) {
    return absl::InvalidArgumentError("the payload is compressed already");
  }
  if (absl::Status status = Check(raw, resolution_m); !status.ok()) return status;
  absl::StatusOr<std::vector<Column>> columns = ListColumns(raw);
  if (!columns.ok()) return columns.status();

  const size_t n = PointCount(raw);
  std::string content;
  std::string data(kMagic, sizeof(kMagic));
  data.resize(kHeaderSize, '\0');
  for (const Column& column : *columns) {
    Transform transform = Transform::kCoordinate;
    if (!column.is_coordinate) {
      transform = EncodeColumn(raw.data.data() + column.offset, raw.stride, n, SizeOf(column.type),
                               content);
    } else if (auto status = EncodeCoordinate(raw, column, resolution_m, content); !status.ok()) {
      return status;
    }
    data.push_back(static_cast<char>(transform));
  }
  if (absl::Status status = AppendZstdFrame(content, data); !status.ok()) return status;
  StoreAs(io::Crc32c(&data[kHeaderSize], data.size() - kHeaderSize), &data[4]);

  PointPayload quantized;
  quantized.encoding = PayloadEncoding::kQuantized;
  quantized.width = raw.width;
  quantized.height = raw.height;
  quantized.stride = raw.stride;
  quantized.fields = raw.fields;
  quantized.resolution_m = resolution_m;
  quantized.data = std::move(data);
  return quantized;
}

absl::StatusOr<PointPayload> Dequantize(const PointPayload& quantized) {
  if (quantized.encoding != PayloadEncoding::kQuantized) {
    return absl::InvalidArgumentError("the payload is not quantised");
  }
  if (auto status = Check(quantized, quantized.resolution_m); !status.ok()) return status;
  absl::StatusOr<std::vector<Column>> columns = ListColumns(quantized);
  if (!columns.ok()) return columns.status();
  if (auto status = CheckHeader(quantized, *columns); !status.ok()) return status;
  absl::StatusOr<std::string> content = OpenFrame(quantized, *columns);
  if (!content.ok()) return content.status();

  PointPayload raw;
  raw.width = quantized.width;
  raw.height = quantized.height;
  raw.stride = quantized.stride;
  raw.fields = quantized.fields;
  const size_t n = PointCount(raw);
  raw.data.resize(n * raw.stride);
  const char* in = content->data();
  for (size_t c = 0; c < columns->size(); ++c) {
    const Column& column = (*columns)[c];
    const Transform transform = TransformOf(quantized, c);
    if (column.is_coordinate) {
      DecodeCoordinate(in, column, quantized.resolution_m, raw);
    } else {
      DecodeColumn(transform, in, n, SizeOf(column.type), raw.data.data() + column.offset,
                   raw.stride);
    }
    in += EncodedSize(transform, SizeOf(column.type), n);
  }
  return raw;
}

}  // namespace isthmus::codec
