#include "client/readers/messages/bag/bag_chunks.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "client/readers/messages/bag/bag_records.h"
#include "client/readers/messages/limits.h"
#include "client/readers/messages/unpack.h"
#include "core/codec/column.h"

namespace isthmus::readers {

absl::Status BagBlockFormat::Load(const MessageBlock& block, std::string* content) const {
  if (!block.loose) return LoadChunk(block, content);
  content->resize(block.end - block.begin);
  return source_->Read(block.begin, content->size(), content->data());
}

absl::Status BagBlockFormat::LoadChunk(const MessageBlock& block, std::string* content) const {
  content->clear();
  ByteWindow window(*source_, kChunkHeadBytes);
  absl::StatusOr<BagHead> head = ReadBagHead(window, block.begin);
  if (!head.ok()) return head.status();
  if (head->header.op != BagOp::kChunk) return absl::DataLossError("no chunk begins there");
  const std::string name(head->header.compression);
  const std::optional<Compression> compression = CompressionOf(name);
  if (!compression) {
    return absl::DataLossError(absl::StrCat("the compression '", name, "' is not known"));
  }
  // A recorder fills in both sizes when it ends a chunk.
  const bool open = head->data_end == head->data_begin && head->header.size == 0;
  const bool cut = open || head->data_end > source_->size();
  const uint64_t end = cut ? block.end : head->data_end;
  const uint64_t claimed = open ? kMaxChunkBytes : head->header.size;
  if (end - head->data_begin > kMaxChunkBytes) {
    return absl::DataLossError(absl::StrCat("a chunk has more than ", kMaxChunkBytes, " bytes"));
  }
  std::string packed(end - head->data_begin, '\0');
  if (auto read = source_->Read(head->data_begin, packed.size(), packed.data()); !read.ok()) {
    return read;
  }
  if (*compression == Compression::kNone) {
    *content = std::move(packed);
    return cut ? absl::OutOfRangeError("the file ends within a chunk") : absl::OkStatus();
  }
  absl::Status status = Unpack(*compression, packed, claimed, content);
  if (absl::IsOutOfRange(status) && !cut) return absl::DataLossError(status.message());
  return status;
}

absl::StatusOr<BlockRecord> BagBlockFormat::Parse(absl::string_view content, size_t at) const {
  return ParseBagRecord(content, at);
}

absl::Status ReadBagIndex(const ByteSource& source, uint64_t index_pos, uint32_t connections,
                          uint32_t chunks, BlockFile* file) {
  ByteWindow window(source, kWindowBytes);
  uint64_t at = index_pos;
  uint32_t connections_read = 0;
  while (at < source.size()) {
    absl::StatusOr<BagHead> head = ReadBagHead(window, at);
    if (!head.ok()) return head.status();
    const BagHeader header = head->header;
    const std::string topic(header.topic);
    const uint64_t size = head->data_end - head->data_begin;
    if (size > kMaxSmallRecordBytes)
      return absl::DataLossError("a record of the index is too long");
    absl::StatusOr<absl::string_view> data = window.At(head->data_begin, size);
    if (!data.ok()) return data.status();
    if (header.op == BagOp::kConnection) {
      file->numbered[header.conn] = ParseConnection(topic, *data);
      ++connections_read;
    } else if (header.op == BagOp::kChunkInfo) {
      if (header.chunk_pos >= index_pos || size / 8 < header.count) {
        return absl::DataLossError("the index tells of chunks that cannot be");
      }
      MessageBlock block{.begin = header.chunk_pos,
                         .first_ns = header.start_ns(),
                         .last_ns = header.end_ns(),
                         .counts = std::map<uint32_t, uint64_t>()};
      for (uint32_t i = 0; i < header.count; ++i) {
        (*block.counts)[codec::LoadAs<uint32_t>(data->data() + 8 * i)] +=
            codec::LoadAs<uint32_t>(data->data() + 8 * i + 4);
      }
      file->blocks.push_back(std::move(block));
    }
    at = head->data_end;
  }
  if (connections_read < connections || file->blocks.size() != chunks) {
    return absl::DataLossError("the index is not complete");
  }
  std::sort(file->blocks.begin(), file->blocks.end(),
            [](const MessageBlock& a, const MessageBlock& b) { return a.begin < b.begin; });
  for (size_t i = 0; i < file->blocks.size(); ++i) {
    file->blocks[i].end = i + 1 < file->blocks.size() ? file->blocks[i + 1].begin : index_pos;
  }
  return absl::OkStatus();
}

}  // namespace isthmus::readers
