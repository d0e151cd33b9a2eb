#include <absl/strings/str_cat.h>

#include <optional>
#include <utility>
#include <vector>

#include "core/codec/column.h"
#include "core/formats/lzf.h"
#include "core/formats/pcd.h"
#include "core/formats/pcd_ascii.h"
#include "core/formats/pcd_header.h"
#include "core/io/file_io.h"

namespace isthmus::formats {
namespace {

absl::StatusOr<std::string> ReadRecords(const std::string& bytes, const PcdHeader& header) {
  const uint64_t size = bytes.size() - header.data_start;
  const uint32_t stride = header.Stride();
  // Points() may be near 2^64: divide, do not multiply. Some versions of PCL leave a page behind.
  if (header.Points() > size / stride) {
    return absl::InvalidArgumentError(
        absl::StrCat("PCD data: the header announces ", header.Points(), " points of ", stride,
                     " bytes, but there are ", size, " bytes of data"));
  }
  return bytes.substr(header.data_start, header.Points() * stride);
}

// Field by field, as PCL compresses them, to point by point.
absl::StatusOr<std::string> ReadCompressed(const std::string& bytes, const PcdHeader& header) {
  const uint64_t n = header.Points();
  const uint32_t stride = header.Stride();
  if (n > (uint64_t{1} << 32) / stride) {
    return absl::InvalidArgumentError("PCD header: more points than compressed data can hold");
  }
  absl::StatusOr<std::string> columns =
      ReadLzfBlock(bytes.data() + header.data_start, bytes.size() - header.data_start, n * stride);
  if (!columns.ok()) return columns.status();
  std::string records(n * stride, '\0');
  const char* in = columns->data();
  uint64_t offset = 0;
  for (const PcdField& field : header.fields) {
    const uint32_t width = field.Bytes();
    for (uint64_t i = 0; i < n; ++i, in += width) {
      std::memcpy(records.data() + i * stride + offset, in, width);
    }
    offset += width;
  }
  return records;
}

// 8-byte integers become float64 where they stand.
void ConvertWideIntegers(const PcdField& field, uint32_t offset, PointPayload& payload) {
  for (uint64_t i = 0; i < uint64_t{payload.width} * payload.height; ++i) {
    char* value = payload.data.data() + i * payload.stride + offset;
    for (uint32_t k = 0; k < field.count; ++k, value += 8) {
      codec::StoreAs(field.kind == 'I' ? static_cast<double>(codec::LoadAs<int64_t>(value))
                                       : static_cast<double>(codec::LoadAs<uint64_t>(value)),
                     value);
    }
  }
}

void ListFields(const PcdHeader& header, PointPayload& payload) {
  uint32_t offset = 0;
  for (const PcdField& field : header.fields) {
    const uint32_t begin = std::exchange(offset, offset + field.Bytes());
    const std::optional<ScalarType> type = ToScalarType(field);
    if (!type) continue;
    payload.fields.push_back({field.name, begin, *type, field.count});
    const bool wide_integer = field.size == 8 && field.kind != 'F';
    if (wide_integer && header.encoding != PcdEncoding::kAscii) {
      ConvertWideIntegers(field, begin, payload);
    }
  }
}

// Takes the bytes out that data of this encoding does not have, or that nothing needs of it. Made
// room for, they would take what no file holds.
void TakePaddingOut(PcdHeader& header) {
  if (header.encoding == PcdEncoding::kBinaryCompressed) {
    std::erase_if(header.fields, [](const PcdField& field) { return field.IsPadding(); });
  } else if (header.encoding == PcdEncoding::kAscii) {
    for (PcdField& field : header.fields) {
      if (!ToScalarType(field)) field.size = 0;
    }
  }
}

}  // namespace

absl::StatusOr<PcdFile> ParsePcd(const std::string& bytes) {
  absl::StatusOr<PcdHeader> header = ParsePcdHeader(bytes);
  if (!header.ok()) return header.status();
  TakePaddingOut(*header);
  if (header->Stride() == 0) return absl::InvalidArgumentError("PCD header: nothing but padding");
  absl::StatusOr<std::string> records;
  switch (header->encoding) {
    case PcdEncoding::kAscii:
      records = ParsePcdRows(bytes, *header);
      break;
    case PcdEncoding::kBinary:
      records = ReadRecords(bytes, *header);
      break;
    case PcdEncoding::kBinaryCompressed:
      records = ReadCompressed(bytes, *header);
      break;
  }
  if (!records.ok()) return records.status();
  PcdFile file;
  file.viewpoint = header->viewpoint;
  file.encoding = header->encoding;
  file.payload.width = header->width;
  file.payload.height = header->height;
  file.payload.stride = header->Stride();
  file.payload.data = *std::move(records);
  ListFields(*header, file.payload);
  return file;
}

absl::StatusOr<PcdFile> ReadPcd(const std::string& path) {
  absl::StatusOr<std::string> bytes = io::ReadFile(path);
  if (!bytes.ok()) return bytes.status();
  absl::StatusOr<PcdFile> file = ParsePcd(*bytes);
  if (file.ok()) return file;
  return absl::Status(file.status().code(), absl::StrCat(path, ": ", file.status().message()));
}

}  // namespace isthmus::formats
