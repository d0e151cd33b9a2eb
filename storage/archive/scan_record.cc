#include "storage/archive/scan_record.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "core/byte_stream.h"
#include "core/codec/column_transform.h"
#include "core/codec/payload_layout.h"
#include "core/codec/zstd_frame.h"

namespace isthmus::storage {
namespace {

// The packing of a payload's data; stored.
enum class Packing : uint8_t {
  kAsItIs = 0,
  kFrame = 1,    // A zstd frame.
  kColumns = 2,  // A zstd frame of the columns of its records.
};

// Every scan is packed while robots wait: quick rather than small.
constexpr int kLevel = 1;
// Larger ones cannot come through the network (network.max_receive_bytes).
constexpr size_t kMaxScanBody = 1u << 30;

struct PayloadColumn {
  uint32_t offset = 0;
  uint32_t width = 1;  // Bytes: 1, 2, 4 or 8.
};

// The values of all fields that do not overlap an earlier one, and every byte that belongs to none.
std::vector<PayloadColumn> ListColumns(const PointPayload& payload) {
  std::vector<PayloadColumn> columns;
  std::vector<bool> taken(payload.stride, false);
  for (const PointField& field : payload.fields) {
    const uint32_t width = SizeOf(field.type);
    for (uint32_t k = 0; k < field.count; ++k) {
      const auto begin = taken.begin() + field.offset + k * width;
      if (std::find(begin, begin + width, true) != begin + width) continue;
      std::fill(begin, begin + width, true);
      columns.push_back({field.offset + k * width, width});
    }
  }
  for (uint32_t at = 0; at < payload.stride; ++at) {
    if (!taken[at]) columns.push_back({at, 1});
  }
  return columns;
}

bool HasColumns(const PointPayload& payload) {
  return payload.encoding == PayloadEncoding::kRaw && codec::CheckLayout(payload).ok();
}

// Each column as its transform and the bytes that this makes.
std::string EncodeColumns(const PointPayload& payload) {
  const size_t n = codec::PointCount(payload);
  std::string content;
  content.reserve(payload.data.size() + 16 * payload.fields.size());
  for (const PayloadColumn& column : ListColumns(payload)) {
    const size_t transform_at = content.size();
    content.push_back(0);
    content[transform_at] = static_cast<char>(codec::EncodeColumn(
        payload.data.data() + column.offset, payload.stride, n, column.width, content));
  }
  return content;
}

absl::Status DecodeColumns(const std::string& content, PointPayload& payload) {
  const absl::Status damaged = absl::DataLossError("its columns do not fit its layout");
  if (!HasColumns(payload)) return damaged;
  const size_t n = codec::PointCount(payload);
  size_t at = 0;
  for (const PayloadColumn& column : ListColumns(payload)) {
    if (at >= content.size()) return damaged;
    const auto transform = static_cast<codec::Transform>(content[at++]);
    if (transform > codec::Transform::kPalette || transform == codec::Transform::kCoordinate) {
      return damaged;
    }
    const size_t size = codec::EncodedSize(transform, column.width, n);
    if (content.size() - at < size) return damaged;
    codec::DecodeColumn(transform, content.data() + at, n, column.width,
                        payload.data.data() + column.offset, payload.stride);
    at += size;
  }
  return at == content.size() ? absl::OkStatus() : damaged;
}

void AppendLayout(const PointPayload& payload, std::string& out) {
  AppendBytes(static_cast<uint8_t>(payload.encoding), out);
  AppendBytes(payload.width, out);
  AppendBytes(payload.height, out);
  AppendBytes(payload.stride, out);
  AppendBytes(payload.resolution_m, out);
  AppendBytes(static_cast<uint32_t>(payload.fields.size()), out);
  for (const PointField& field : payload.fields) {
    AppendBytes(static_cast<uint32_t>(field.name.size()), out);
    out += field.name;
    AppendBytes(field.offset, out);
    AppendBytes(static_cast<uint8_t>(field.type), out);
    AppendBytes(field.count, out);
  }
}

bool ReadLayout(ByteReader& reader, PointPayload& payload) {
  payload.encoding = static_cast<PayloadEncoding>(reader.Read<uint8_t>());
  payload.width = reader.Read<uint32_t>();
  payload.height = reader.Read<uint32_t>();
  payload.stride = reader.Read<uint32_t>();
  payload.resolution_m = reader.Read<double>();
  const uint32_t count = reader.Read<uint32_t>();
  for (uint32_t i = 0; i < count && reader.ok(); ++i) {
    PointField field;
    const uint32_t length = reader.Read<uint32_t>();
    if (!reader.ok() || length > reader.remaining()) return false;
    field.name = reader.ReadString(length);
    field.offset = reader.Read<uint32_t>();
    field.type = static_cast<ScalarType>(reader.Read<uint8_t>());
    field.count = reader.Read<uint32_t>();
    payload.fields.push_back(std::move(field));
  }
  return reader.ok();
}

// Packs in the way that is probably best: data that is compressed already is left as it is.
absl::Status AppendData(const PointPayload& payload, std::string& body) {
  Packing packing = HasColumns(payload)                               ? Packing::kColumns
                    : payload.encoding == PayloadEncoding::kQuantized ? Packing::kAsItIs
                                                                      : Packing::kFrame;
  std::string columns;
  if (packing == Packing::kColumns) columns = EncodeColumns(payload);
  const std::string& content = packing == Packing::kColumns ? columns : payload.data;
  AppendBytes(static_cast<uint8_t>(packing), body);
  AppendBytes(static_cast<uint64_t>(payload.data.size()), body);
  AppendBytes(static_cast<uint64_t>(content.size()), body);
  if (packing != Packing::kAsItIs) return codec::AppendZstdFrame(content, body, kLevel);
  body += content;
  return absl::OkStatus();
}

absl::Status ReadData(ByteReader& reader, PointPayload& payload) {
  const auto packing = static_cast<Packing>(reader.Read<uint8_t>());
  const uint64_t data_size = reader.Read<uint64_t>();
  const uint64_t content_size = reader.Read<uint64_t>();
  if (!reader.ok() || data_size > codec::kMaxDecodedBytes ||
      content_size > 2 * codec::kMaxDecodedBytes) {
    return absl::DataLossError("its sizes make no sense");
  }
  std::string rest = reader.Rest();
  if (packing == Packing::kAsItIs) {
    if (rest.size() != data_size) return absl::DataLossError("its data has another size");
    payload.data = std::move(rest);
    return absl::OkStatus();
  }
  absl::StatusOr<std::string> content =
      codec::ReadZstdFrame(rest.data(), rest.size(), static_cast<size_t>(content_size));
  if (!content.ok()) return absl::DataLossError(content.status().message());
  if (packing == Packing::kFrame && content_size == data_size) {
    payload.data = *std::move(content);
    return absl::OkStatus();
  }
  if (packing != Packing::kColumns) return absl::DataLossError("its packing is not known");
  payload.data.resize(static_cast<size_t>(data_size));
  return DecodeColumns(*content, payload);
}

}  // namespace

absl::StatusOr<std::string> EncodeScan(const ScanUpload& scan) {
  if (scan.payload.data.size() > codec::kMaxDecodedBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat("a scan of ", scan.payload.data.size(), " bytes is too large to be kept"));
  }
  std::string body;
  AppendLayout(scan.payload, body);
  if (absl::Status status = AppendData(scan.payload, body); !status.ok()) return status;
  if (body.size() > kMaxScanBody) {
    return absl::InvalidArgumentError("the names of a scan's fields are too large to be kept");
  }
  return body;
}

absl::StatusOr<ScanUpload> DecodeScan(const io::Record& record, const std::string& body) {
  ScanUpload scan;
  scan.sequence = record.sequence;
  scan.end_stamp_ns = record.stamp_ns;
  ByteReader reader(body);
  if (!ReadLayout(reader, scan.payload)) return absl::DataLossError("its layout is damaged");
  if (absl::Status status = ReadData(reader, scan.payload); !status.ok()) return status;
  return scan;
}

}  // namespace isthmus::storage
