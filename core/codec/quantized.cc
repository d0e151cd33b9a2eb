#include "core/codec/quantized.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/codec/byte_shuffle.h"
#include "core/codec/column.h"
#include "core/codec/crc32c.h"
#include "core/codec/delta_code.h"
#include "core/codec/payload_layout.h"
#include "core/codec/zstd_frame.h"

namespace isthmus::codec {
namespace {

constexpr char kMagic[3] = {'I', 'Q', 1};  // The last byte is the version.
constexpr size_t kHeaderSize = 8;          // Magic, a zero, checksum.

// How the values of a column became the bytes that are shuffled.
enum class Transform : char { kPlain = 0, kDelta = 1, kCoordinate = 2 };

// One value per point: a field, or one element of a field with count > 1.
struct Column {
  uint32_t offset = 0;
  ScalarType type = ScalarType::kFloat32;
  bool is_coordinate = false;

  uint32_t EncodedWidth() const { return is_coordinate ? 4 : SizeOf(type); }
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

size_t EncodedSize(const std::vector<Column>& columns, uint64_t points) {
  size_t size = 0;
  for (const Column& column : columns) size += points * column.EncodedWidth();
  return size;
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

template <typename Word>
Word LoadWord(const PointPayload& raw, const Column& column, size_t i) {
  return LoadAs<Word>(raw.data.data() + column.offset + i * raw.stride);
}

// Whether neighbouring differences share more bytes than neighbouring values, in a sample from the
// middle of the cloud: so for rings and times, not for intensities.
template <typename Word>
bool DeltaPacksBetter(const PointPayload& raw, const Column& column) {
  const size_t n = PointCount(raw);
  const size_t sample = std::min<size_t>(n, 2048);
  size_t plain_changes = 0, delta_changes = 0;
  Word last = 0, last_delta = 0;
  for (size_t i = (n - sample) / 2; i < (n - sample) / 2 + sample; ++i) {
    const Word value = LoadWord<Word>(raw, column, i);
    const Word delta = static_cast<Word>(value - last);
    for (size_t shift = 0; shift < 8 * sizeof(Word); shift += 8) {
      plain_changes += (((value ^ last) >> shift) & 0xFF) != 0;
      delta_changes += (((delta ^ last_delta) >> shift) & 0xFF) != 0;
    }
    last = value;
    last_delta = delta;
  }
  return delta_changes * 10 < plain_changes * 9;
}

// Calls `visitor` with an unsigned integer of the width of `type`.
template <typename Visitor>
auto VisitWord(ScalarType type, const Visitor& visitor) {
  switch (SizeOf(type)) {
    case 1:
      return visitor(uint8_t{});
    case 2:
      return visitor(uint16_t{});
    case 4:
      return visitor(uint32_t{});
    default:
      return visitor(uint64_t{});
  }
}

Transform EncodePlain(const PointPayload& raw, const Column& column, char* out) {
  return VisitWord(column.type, [&](auto zero) {
    using Word = decltype(zero);
    const size_t n = PointCount(raw);
    if (!DeltaPacksBetter<Word>(raw, column)) {
      Shuffle(raw.data.data() + column.offset, n, sizeof(Word), raw.stride, out);
      return Transform::kPlain;
    }
    std::vector<Word> deltas(n);
    Word last = 0;
    for (size_t i = 0; i < n; ++i) {
      const Word value = LoadWord<Word>(raw, column, i);
      deltas[i] = static_cast<Word>(value - last);
      last = value;
    }
    Shuffle(reinterpret_cast<const char*>(deltas.data()), n, sizeof(Word), sizeof(Word), out);
    return Transform::kDelta;
  });
}

void SumDeltas(const Column& column, PointPayload& raw) {
  VisitWord(column.type, [&](auto last) {
    using Word = decltype(last);
    for (size_t i = 0; i < PointCount(raw); ++i) {
      last = static_cast<Word>(last + LoadWord<Word>(raw, column, i));
      StoreAs(last, raw.data.data() + column.offset + i * raw.stride);
    }
  });
}

absl::Status EncodeCoordinate(const PointPayload& raw, const Column& column, double resolution_m,
                              char* out) {
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
  Shuffle(reinterpret_cast<const char*>(codes.data()), n, 4, 4, out);
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

// The zstd frame's content, after the header and the column transforms were checked.
absl::StatusOr<std::string> OpenFrame(const PointPayload& quantized,
                                      const std::vector<Column>& columns) {
  const std::string& data = quantized.data;
  const size_t frame_start = kHeaderSize + columns.size();
  if (data.size() <= frame_start || data[0] != kMagic[0] || data[1] != kMagic[1]) {
    return absl::InvalidArgumentError("the data is not a quantised payload of these fields");
  }
  if (data[2] != kMagic[2] || data[3] != 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("quantised payload of version ", static_cast<int>(data[2]),
                     "; this program reads version ", static_cast<int>(kMagic[2])));
  }
  if (LoadAs<uint32_t>(&data[4]) != Crc32c(&data[kHeaderSize], data.size() - kHeaderSize)) {
    return absl::InvalidArgumentError("the checksum of the quantised payload is wrong");
  }
  for (size_t c = 0; c < columns.size(); ++c) {
    const auto transform = static_cast<Transform>(data[kHeaderSize + c]);
    const bool known = columns[c].is_coordinate
                           ? transform == Transform::kCoordinate
                           : transform == Transform::kPlain || transform == Transform::kDelta;
    if (!known) return absl::InvalidArgumentError("the fields do not fit the quantised payload");
  }
  return ReadZstdFrame(&data[frame_start], data.size() - frame_start,
                       EncodedSize(columns, PointCount(quantized)));
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
  std::string planes(EncodedSize(*columns, n), '\0');
  std::string data(kMagic, sizeof(kMagic));
  data.resize(kHeaderSize, '\0');
  char* out = planes.data();
  for (const Column& column : *columns) {
    Transform transform = Transform::kCoordinate;
    if (!column.is_coordinate) {
      transform = EncodePlain(raw, column, out);
    } else if (auto status = EncodeCoordinate(raw, column, resolution_m, out); !status.ok()) {
      return status;
    }
    data.push_back(static_cast<char>(transform));
    out += n * column.EncodedWidth();
  }
  if (absl::Status status = AppendZstdFrame(planes, data); !status.ok()) return status;
  StoreAs(Crc32c(&data[kHeaderSize], data.size() - kHeaderSize), &data[4]);

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
  absl::StatusOr<std::string> planes = OpenFrame(quantized, *columns);
  if (!planes.ok()) return planes.status();

  PointPayload raw;
  raw.width = quantized.width;
  raw.height = quantized.height;
  raw.stride = quantized.stride;
  raw.fields = quantized.fields;
  const size_t n = PointCount(raw);
  raw.data.resize(n * raw.stride);
  const char* in = planes->data();
  for (size_t c = 0; c < columns->size(); ++c) {
    const Column& column = (*columns)[c];
    if (column.is_coordinate) {
      DecodeCoordinate(in, column, quantized.resolution_m, raw);
    } else {
      Unshuffle(in, n, SizeOf(column.type), raw.data.data() + column.offset, raw.stride);
      const auto transform = static_cast<Transform>(quantized.data[kHeaderSize + c]);
      if (transform == Transform::kDelta) SumDeltas(column, raw);
    }
    in += n * column.EncodedWidth();
  }
  return raw;
}

}  // namespace isthmus::codec
