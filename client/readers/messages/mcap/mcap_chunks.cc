#include "client/readers/messages/mcap/mcap_chunks.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "client/readers/messages/limits.h"
#include "client/readers/messages/mcap/mcap_records.h"
#include "client/readers/messages/unpack.h"
#include "core/io/crc32.h"

namespace isthmus::readers {
namespace {

absl::Status UnpackChunk(absl::string_view record, bool cut, std::string* content) {
  const std::optional<McapChunkHeader> header = ParseMcapChunk(record);
  if (!header) return absl::DataLossError("the head of a chunk is damaged");
  const std::optional<Compression> compression = CompressionOf(header->compression);
  if (!compression) {
    return absl::DataLossError(
        absl::StrCat("the compression '", header->compression, "' is not known"));
  }
  const absl::string_view packed = record.substr(header->records_begin);
  if (!cut && packed.size() < header->packed_size) {
    return absl::DataLossError("the head of a chunk is damaged");
  }
  absl::Status status =
      Unpack(*compression, packed.substr(0, header->packed_size), header->unpacked_size, content);
  if (absl::IsOutOfRange(status) && !cut) return absl::DataLossError(status.message());
  if (status.ok() && header->unpacked_crc != 0 && header->unpacked_crc != io::Crc32(*content)) {
    return absl::DataLossError("the CRC of a chunk is wrong");
  }
  return status;
}

}  // namespace

absl::Status McapBlockFormat::Load(const MessageBlock& block, std::string* content) const {
  content->clear();
  if (block.end < block.begin || block.begin > source_->size() ||
      block.end - block.begin > 2 * kMaxChunkBytes) {
    return absl::DataLossError("no chunk can be there");
  }
  // The index may be right and the file cut off.
  const uint64_t end = std::min(block.end, source_->size());
  std::string record(end - block.begin, '\0');
  if (auto read = source_->Read(block.begin, record.size(), record.data()); !read.ok()) return read;
  if (block.loose) {
    *content = std::move(record);
    return absl::OkStatus();
  }
  ByteWindow window(*source_, kMcapHeadBytes);
  absl::StatusOr<McapHead> head = ReadMcapHead(window, block.begin);
  if (!head.ok()) return head.status();
  if (head->op != McapOp::kChunk) return absl::DataLossError("no chunk begins there");
  return UnpackChunk(absl::string_view(record).substr(kMcapHeadBytes), head->end > source_->size(),
                     content);
}

absl::StatusOr<BlockRecord> McapBlockFormat::Parse(absl::string_view content, size_t at) const {
  return ParseMcapRecord(content, at);
}

}  // namespace isthmus::readers
