// The records of MCAP.
//
// Source: "MCAP Format Specification", mcap.dev/spec, sections Records and Opcodes: a record is an
// opcode (1 byte), the length of its content (uint64) and the content. Little endian.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "client/readers/messages/block_reader.h"
#include "client/readers/messages/byte_source.h"

namespace isthmus::readers {

inline constexpr absl::string_view kMcapMagic("\x89MCAP0\r\n", 8);
inline constexpr size_t kMcapHeadBytes = 9;     // Format: of a record, before its content.
inline constexpr size_t kMcapFooterBytes = 20;  // Format: of the content of a footer.

enum class McapOp : uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kDataEnd = 0x0F,
};

// A record of a file, without its content.
struct McapHead {
  McapOp op = McapOp::kHeader;  // May be one that is not listed: to be skipped.
  uint64_t begin = 0, end = 0;  // Bytes of the content; the file may end before.
};

// DataLoss where the file ends within these bytes, or no record can begin with them.
absl::StatusOr<McapHead> ReadMcapHead(ByteWindow& window, uint64_t offset);

// The fields of a chunk before its records.
struct McapChunkHeader {
  int64_t first_ns = 0, last_ns = 0;  // When the first and last of its messages were recorded.
  uint64_t unpacked_size = 0;
  uint32_t unpacked_crc = 0;  // 0: none.
  absl::string_view compression;
  uint64_t packed_size = 0;
  size_t records_begin = 0;  // In the content of the record.
};
// `content` may end behind the header.
std::optional<McapChunkHeader> ParseMcapChunk(absl::string_view content);

// The record at byte `at` of a chunk's records.
absl::StatusOr<BlockRecord> ParseMcapRecord(absl::string_view records, size_t at);
// The part of it that its content tells, for the opcodes message, channel and schema. Empty where
// it does not fit.
std::optional<BlockRecord> ParseMcapContent(McapOp op, absl::string_view content);

}  // namespace isthmus::readers
