#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>

#include <algorithm>

#include "core/codec/column.h"
#include "core/formats/lzf.h"
#include "core/formats/pcd.h"
#include "core/formats/pcd_ascii.h"
#include "core/formats/pcd_header.h"
#include "core/io/file_io.h"

namespace isthmus::formats {
namespace {

absl::StatusOr<PcdHeader> MakeHeader(const PointPayload& raw, PcdEncoding encoding,
                                     const Pose& viewpoint) {
  PcdHeader header;
  header.width = raw.width;
  header.height = raw.height;
  header.viewpoint = viewpoint;
  header.encoding = encoding;
  for (const PointField& field : raw.fields) {
    const bool printable = std::all_of(field.name.begin(), field.name.end(), [](char c) {
      return absl::ascii_isgraph(static_cast<unsigned char>(c));
    });
    if (field.name.empty() || field.name == "_" || !printable) {
      return absl::InvalidArgumentError(
          absl::StrCat("'", field.name, "' cannot be the name of a field in a PCD file"));
    }
    header.fields.push_back(ToPcdField(field.name, field.type, field.count));
  }
  return header;
}

std::string FormatRows(const PointPayload& raw) {
  std::string text;
  for (uint64_t i = 0; i < codec::PointCount(raw); ++i) {
    const char* record = raw.data.data() + i * raw.stride;
    for (const PointField& field : raw.fields) {
      for (uint32_t k = 0; k < field.count; ++k) {
        AppendValue(record + field.offset + k * SizeOf(field.type), field.type, text);
        text.push_back(' ');
      }
    }
    text.back() = '\n';
  }
  return text;
}

// Fields in their order without gaps: point by point, or field by field.
std::string Pack(const PointPayload& raw, uint32_t packed_stride, bool by_field) {
  const uint64_t n = codec::PointCount(raw);
  std::string packed(n * packed_stride, '\0');
  uint64_t before = 0;  // Bytes of a point that the fields before this one take.
  for (const PointField& field : raw.fields) {
    const uint32_t width = SizeOf(field.type) * field.count;
    char* out = packed.data() + (by_field ? before * n : before);
    const uint32_t step = by_field ? width : packed_stride;
    for (uint64_t i = 0; i < n; ++i) {
      std::memcpy(out + i * step, raw.data.data() + i * raw.stride + field.offset, width);
    }
    before += width;
  }
  return packed;
}

}  // namespace

absl::StatusOr<std::string> FormatPcd(const PointPayload& raw, PcdEncoding encoding,
                                      const Pose& viewpoint) {
  if (absl::Status status = codec::CheckRawLayout(raw); !status.ok()) return status;
  absl::StatusOr<PcdHeader> header = MakeHeader(raw, encoding, viewpoint);
  if (!header.ok()) return header.status();
  const std::string text = FormatPcdHeader(*header);
  switch (encoding) {
    case PcdEncoding::kAscii:
      return text + FormatRows(raw);
    case PcdEncoding::kBinary:
      return text + Pack(raw, header->Stride(), /*by_field=*/false);
    case PcdEncoding::kBinaryCompressed:
      break;
  }
  absl::StatusOr<std::string> block = LzfBlock(Pack(raw, header->Stride(), /*by_field=*/true));
  if (!block.ok()) return absl::InvalidArgumentError(block.status().message());
  return text + *block;
}

absl::Status WritePcd(const std::string& path, const PointPayload& raw, PcdEncoding encoding,
                      const Pose& viewpoint) {
  absl::StatusOr<std::string> bytes = FormatPcd(raw, encoding, viewpoint);
  if (bytes.ok()) return io::WriteFile(path, *bytes);
  return absl::Status(bytes.status().code(), absl::StrCat(path, ": ", bytes.status().message()));
}

}  // namespace isthmus::formats
