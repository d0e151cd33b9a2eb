#include "core/codec/quantized.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/byte_stream.h"
#include "core/codec/byte_shuffle.h"
#include "core/codec/column.h"
#include "core/codec/column_transform.h"
#include "core/codec/delta_code.h"
#include "core/codec/payload_layout.h"
#include "core/codec/quantized_columns.h"
#include "core/codec/quantized_rays.h"
#include "core/codec/zstd_frame.h"
#include "core/io/crc32c.h"

namespace isthmus::codec {
namespace {

constexpr char kMagic[2] = {'I', 'Q'};
constexpr size_t kVersionAt = 2;  // Behind it a zero, then the checksum.

// False when a coordinate is out of range.
template <typename T>
bool QuantizeColumn(const char* in, uint32_t stride, size_t n, double resolution_m,
                    std::vector<uint32_t>& codes) {
  const double scale = 1.0 / resolution_m;
  DeltaEncoder encoder;
  bool in_range = true;
  for (size_t i = 0; i < n; ++i) {
    int32_t steps = 0;
    const Rounded rounded = RoundToSteps(LoadAs<T>(in + i * stride), scale, &steps);
    codes[i] = rounded == Rounded::kSteps ? encoder.Encode(steps) : kNoValueCode;
    in_range = in_range && rounded != Rounded::kTooFar;
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
  if (!in_range) return CoordinateTooFar(resolution_m);
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
  return static_cast<Transform>(quantized.data[kQuantizedHeaderSize + column]);
}

// Magic, version and checksum.
absl::Status CheckHeader(const PointPayload& quantized, const std::vector<Column>& columns) {
  const std::string& data = quantized.data;
  if (data.size() <= kQuantizedHeaderSize + columns.size() || data[0] != kMagic[0] ||
      data[1] != kMagic[1]) {
    return absl::InvalidArgumentError("the data is not a quantised payload of these fields");
  }
  const int version = static_cast<unsigned char>(data[kVersionAt]);
  if (version < 1 || version > kQuantizedVersion || data[kVersionAt + 1] != 0) {
    return absl::InvalidArgumentError(absl::StrCat("quantised payload of version ", version,
                                                   "; this program reads versions 1 to ",
                                                   kQuantizedVersion));
  }
  const uint32_t checksum =
      io::Crc32c(&data[kQuantizedHeaderSize], data.size() - kQuantizedHeaderSize);
  if (LoadAs<uint32_t>(&data[4]) != checksum) {
    return absl::InvalidArgumentError("the checksum of the quantised payload is wrong");
  }
  return absl::OkStatus();
}

// The transforms of version 1.
absl::Status CheckTransforms(const PointPayload& quantized, const std::vector<Column>& columns) {
  for (size_t c = 0; c < columns.size(); ++c) {
    const Transform transform = TransformOf(quantized, c);
    if (columns[c].is_coordinate ? transform != Transform::kCoordinate : !IsLossless(transform)) {
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
  const size_t start = kQuantizedHeaderSize + columns.size();
  return ReadZstdFrame(&quantized.data[start], quantized.data.size() - start, size);
}

// Fewer points than these share blocks: a block begins with a code of a hundred bytes.
constexpr size_t kLeastPlane = 4096;

// Adds the places where a column of the transform, which ends at `end`, is to be cut for the
// compressor: behind each of its byte planes.
void AddEnds(Transform transform, size_t width, size_t n, size_t end, std::vector<size_t>& ends) {
  if (n < kLeastPlane) return;
  if (transform == Transform::kCoordinate) width = sizeof(uint32_t);
  if (transform == Transform::kPalette) width = 1;
  for (size_t plane = width; plane-- > 0;) ends.push_back(end - plane * n);
}

std::vector<absl::string_view> Parts(const std::string& content, const std::vector<size_t>& ends) {
  if (ends.empty()) return {content};
  std::vector<absl::string_view> parts;
  size_t begin = 0;
  for (const size_t end : ends) {
    parts.push_back(absl::string_view(content).substr(begin, end - begin));
    begin = end;
  }
  return parts;
}

// Everything behind the header.
absl::StatusOr<std::string> PackDifferences(const PointPayload& raw,
                                            const std::vector<Column>& columns,
                                            double resolution_m) {
  std::string body;
  std::string content;
  std::vector<size_t> ends;
  for (const Column& column : columns) {
    Transform transform = Transform::kCoordinate;
    if (!column.is_coordinate) {
      transform = EncodeColumn(raw.data.data() + column.offset, raw.stride, PointCount(raw),
                               SizeOf(column.type), content);
    } else if (auto status = EncodeCoordinate(raw, column, resolution_m, content); !status.ok()) {
      return status;
    }
    body.push_back(static_cast<char>(transform));
    AddEnds(transform, SizeOf(column.type), PointCount(raw), content.size(), ends);
  }
  if (absl::Status status = AppendZstdFrame(Parts(content, ends), body); !status.ok()) {
    return status;
  }
  return body;
}

absl::Status UnpackDifferences(const PointPayload& quantized, const std::vector<Column>& columns,
                               PointPayload& raw) {
  const size_t n = PointCount(raw);
  if (auto status = CheckTransforms(quantized, columns); !status.ok()) return status;
  absl::StatusOr<std::string> content = OpenFrame(quantized, columns);
  if (!content.ok()) return content.status();
  raw.data.resize(n * raw.stride);
  const char* in = content->data();
  for (size_t c = 0; c < columns.size(); ++c) {
    const Column& column = columns[c];
    const Transform transform = TransformOf(quantized, c);
    if (column.is_coordinate) {
      DecodeCoordinate(in, column, quantized.resolution_m, raw);
    } else {
      DecodeColumn(transform, in, n, SizeOf(column.type), raw.data.data() + column.offset,
                   raw.stride);
    }
    in += EncodedSize(transform, SizeOf(column.type), n);
  }
  return absl::OkStatus();
}

}  // namespace

int QuantizedVersionOf(const PointPayload& quantized) {
  const bool has_one = quantized.encoding == PayloadEncoding::kQuantized &&
                       quantized.data.size() > kQuantizedHeaderSize;
  return has_one ? static_cast<unsigned char>(quantized.data[kVersionAt]) : 0;
}

absl::StatusOr<PointPayload> Quantize(const PointPayload& raw, double resolution_m,
                                      int newest_version) {
  if (raw.encoding != PayloadEncoding::kRaw) {
    return absl::InvalidArgumentError("the payload is compressed already");
  }
  if (absl::Status status = CheckRounded(raw, resolution_m); !status.ok()) return status;
  absl::StatusOr<std::vector<Column>> columns = ListColumns(raw);
  if (!columns.ok()) return columns.status();

  int version = 2;
  std::optional<std::string> body;
  if (newest_version >= 2) body = PackRays(raw, *columns, resolution_m);
  if (!body) {
    absl::StatusOr<std::string> packed = PackDifferences(raw, *columns, resolution_m);
    if (!packed.ok()) return packed.status();
    body = *std::move(packed);
    version = 1;
  }
  PointPayload quantized;
  quantized.encoding = PayloadEncoding::kQuantized;
  quantized.width = raw.width;
  quantized.height = raw.height;
  quantized.stride = raw.stride;
  quantized.fields = raw.fields;
  quantized.resolution_m = resolution_m;
  quantized.data = {kMagic[0], kMagic[1], static_cast<char>(version), 0};
  AppendBytes(io::Crc32c(body->data(), body->size()), quantized.data);
  quantized.data += *body;
  return quantized;
}

absl::StatusOr<PointPayload> Dequantize(const PointPayload& quantized) {
  if (quantized.encoding != PayloadEncoding::kQuantized) {
    return absl::InvalidArgumentError("the payload is not quantised");
  }
  if (auto status = CheckRounded(quantized, quantized.resolution_m); !status.ok()) return status;
  absl::StatusOr<std::vector<Column>> columns = ListColumns(quantized);
  if (!columns.ok()) return columns.status();
  if (auto status = CheckHeader(quantized, *columns); !status.ok()) return status;

  PointPayload raw;
  raw.width = quantized.width;
  raw.height = quantized.height;
  raw.stride = quantized.stride;
  raw.fields = quantized.fields;
  const absl::Status status = QuantizedVersionOf(quantized) == 1
                                  ? UnpackDifferences(quantized, *columns, raw)
                                  : UnpackRays(quantized, *columns, raw);
  if (!status.ok()) return status;
  return raw;
}

}  // namespace isthmus::codec
