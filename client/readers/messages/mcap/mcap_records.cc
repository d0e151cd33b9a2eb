#include "client/readers/messages/mcap/mcap_records.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <limits>

#include "client/readers/messages/field_reader.h"
#include "core/codec/column.h"

namespace isthmus::readers {

absl::StatusOr<McapHead> ReadMcapHead(ByteWindow& window, uint64_t offset) {
  absl::StatusOr<absl::string_view> bytes = window.At(offset, kMcapHeadBytes);
  if (!bytes.ok()) return bytes.status();
  const auto length = codec::LoadAs<uint64_t>(bytes->data() + 1);
  const auto op = static_cast<McapOp>((*bytes)[0]);
  if (op == McapOp{0} || length > std::numeric_limits<int64_t>::max()) {
    return absl::DataLossError(absl::StrCat("no record begins at byte ", offset));
  }
  return McapHead{op, offset + kMcapHeadBytes, offset + kMcapHeadBytes + length};
}

std::optional<McapChunkHeader> ParseMcapChunk(absl::string_view content) {
  FieldReader reader = FieldReader::Plain(content);
  McapChunkHeader header;
  header.first_ns = static_cast<int64_t>(reader.Read<uint64_t>());
  header.last_ns = static_cast<int64_t>(reader.Read<uint64_t>());
  header.unpacked_size = reader.Read<uint64_t>();
  header.unpacked_crc = reader.Read<uint32_t>();
  header.compression = reader.ReadString();
  header.packed_size = reader.Read<uint64_t>();
  header.records_begin = content.size() - reader.remaining();
  if (!reader.ok()) return std::nullopt;
  return header;
}

std::optional<BlockRecord> ParseMcapContent(McapOp op, absl::string_view content) {
  BlockRecord record;
  FieldReader reader = FieldReader::Plain(content);
  if (op == McapOp::kMessage) {
    record.is_message = true;
    record.number = reader.Read<uint16_t>();
    reader.Skip(4);  // Sequence.
    record.log_ns = static_cast<int64_t>(reader.Read<uint64_t>());
    reader.Skip(8);  // Publish time.
    record.bytes = reader.ReadBytes(reader.remaining());
  } else if (op == McapOp::kChannel) {
    record.number = reader.Read<uint16_t>();
    NumberedTopic topic;
    topic.schema = reader.Read<uint16_t>();
    topic.name = std::string(reader.ReadString());
    topic.encoding = std::string(reader.ReadString());
    record.declared = std::move(topic);
  } else if (op == McapOp::kSchema) {
    record.number = reader.Read<uint16_t>();
    record.schema = std::string(reader.ReadString());
  }
  if (!reader.ok()) return std::nullopt;
  return record;
}

absl::StatusOr<BlockRecord> ParseMcapRecord(absl::string_view records, size_t at) {
  const absl::string_view rest = records.substr(at);
  const absl::Status none = absl::DataLossError(
      absl::StrCat("the record at byte ", at, " of the chunk does not fit into it"));
  if (rest.size() < kMcapHeadBytes) return none;
  const auto length = codec::LoadAs<uint64_t>(rest.data() + 1);
  if (length > rest.size() - kMcapHeadBytes) return none;
  std::optional<BlockRecord> record =
      ParseMcapContent(static_cast<McapOp>(rest[0]), rest.substr(kMcapHeadBytes, length));
  if (!record) return none;
  record->end = at + kMcapHeadBytes + length;
  return *std::move(record);
}

}  // namespace isthmus::readers
