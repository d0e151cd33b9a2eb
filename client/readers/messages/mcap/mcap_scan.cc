#include <absl/strings/str_cat.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "client/readers/messages/field_reader.h"
#include "client/readers/messages/limits.h"
#include "client/readers/messages/mcap/mcap_chunks.h"
#include "client/readers/messages/mcap/mcap_records.h"
#include "client/readers/messages/unpack.h"

namespace isthmus::readers {
namespace {

// Goes through an MCAP file without a summary, record by record.
class McapScan {
 public:
  McapScan(const ByteSource& source, BlockFile* file)
      : source_(source), window_(source, kWindowBytes), file_(file) {}

  bool Run() {
    while (at_ < source_.size() && !ended_) {
      absl::StatusOr<McapHead> head = ReadMcapHead(window_, at_);
      if (head.ok()) {
        Take(*head);
      } else {
        LeaveOut(head.status().message());
      }
    }
    // Its message indexes may be cut off.
    LearnLast(/*always=*/true);
    return ended_;
  }

 private:
  void Take(const McapHead& head);
  void TakeChunk(const McapHead& head);
  void TakeIndex(absl::string_view content);
  void TakeLoose(const McapHead& head, BlockRecord record);
  // Notes a damaged block from here to the next chunk.
  void LeaveOut(absl::string_view why, bool may_hold_messages = true);
  std::optional<uint64_t> FindChunk(uint64_t from);
  // The header of a chunk that begins there; its texts are none.
  std::optional<McapChunkHeader> ChunkAt(uint64_t offset);
  void LearnLast(bool always) {
    if (std::exchange(last_is_new_, false)) LearnUnlessKnown(always, file_->blocks.back(), file_);
  }

  const ByteSource& source_;
  ByteWindow window_;
  BlockFile* const file_;
  uint64_t at_ = kMcapMagic.size();
  bool ended_ = false;
  bool last_is_new_ = false;  // The last block is a chunk that LearnLast has not seen.
};

void McapScan::Take(const McapHead& head) {
  if (head.op == McapOp::kChunk) return TakeChunk(head);
  if (head.end > source_.size()) {
    return LeaveOut("the file ends within a record",
                    head.op == McapOp::kMessage || head.op > McapOp::kDataEnd);
  }
  const bool is_loose =
      head.op == McapOp::kMessage || head.op == McapOp::kChannel || head.op == McapOp::kSchema;
  if (is_loose || head.op == McapOp::kMessageIndex) {
    const uint64_t size = head.end - head.begin;
    if (size > kMaxChunkBytes) return LeaveOut("a record is too long");
    absl::StatusOr<absl::string_view> content = window_.At(head.begin, size);
    if (!content.ok()) return LeaveOut(content.status().message());
    if (is_loose) {
      std::optional<BlockRecord> record = ParseMcapContent(head.op, *content);
      if (!record) return LeaveOut("a record is damaged");
      TakeLoose(head, *std::move(record));
    } else {
      TakeIndex(*content);
    }
  }
  // The summary, if any, was of no use.
  ended_ = head.op == McapOp::kDataEnd || head.op == McapOp::kFooter;
  at_ = head.end;
}

void McapScan::TakeChunk(const McapHead& head) {
  const std::optional<McapChunkHeader> header = ChunkAt(at_);
  if (!header) return LeaveOut("the head of a chunk is damaged");
  LearnLast(/*always=*/false);
  const uint64_t end = std::min(head.end, source_.size());
  file_->blocks.push_back(
      {.begin = at_, .end = end, .first_ns = header->first_ns, .last_ns = header->last_ns});
  last_is_new_ = true;
  at_ = end;
}

void McapScan::TakeIndex(absl::string_view content) {
  if (!last_is_new_) return;
  FieldReader reader = FieldReader::Plain(content);
  const auto channel = reader.Read<uint16_t>();
  const uint32_t entries = reader.Read<uint32_t>() / 16;
  if (!reader.ok()) return;
  MessageBlock& block = file_->blocks.back();
  if (!block.counts) block.counts.emplace();
  (*block.counts)[channel] += entries;
}

void McapScan::TakeLoose(const McapHead& head, BlockRecord record) {
  LearnLast(/*always=*/false);
  if (record.declared) file_->numbered.emplace(record.number, *std::move(record.declared));
  if (!record.schema.empty()) file_->schemas.emplace(record.number, std::move(record.schema));
  if (!record.is_message) return;
  std::vector<MessageBlock>& blocks = file_->blocks;
  if (!GoesOn(*file_, at_, record.log_ns)) blocks.push_back({.begin = at_, .loose = true});
  blocks.back().end = head.end;
  NoteMessage(record.number, record.log_ns, &blocks.back());
}

void McapScan::LeaveOut(absl::string_view why, bool may_hold_messages) {
  LearnLast(/*always=*/true);
  const std::optional<uint64_t> chunk = FindChunk(at_ + 1);
  const uint64_t end = chunk.value_or(source_.size());
  // If a recorder was killed, the end of its index is no loss.
  if (!chunk && !may_hold_messages) {
    at_ = end;
    return;
  }
  file_->blocks.push_back({.begin = at_, .end = end, .damage = std::string(why)});
  at_ = end;
}

// Several fields that must agree make it unlikely that anything else is taken for a chunk.
std::optional<McapChunkHeader> McapScan::ChunkAt(uint64_t offset) {
  constexpr size_t kMostHeaderBytes = kMcapHeadBytes + 8 + 8 + 8 + 4 + 4 + 8 + 8;  // Format
  const uint64_t there = std::min<uint64_t>(kMostHeaderBytes, source_.size() - offset);
  absl::StatusOr<absl::string_view> bytes = window_.At(offset, there);
  if (!bytes.ok() || there < kMcapHeadBytes) return std::nullopt;
  const absl::StatusOr<McapHead> head = ReadMcapHead(window_, offset);
  if (!head.ok() || head->op != McapOp::kChunk) return std::nullopt;
  bytes = window_.At(offset, there);
  std::optional<McapChunkHeader> header = ParseMcapChunk(bytes->substr(kMcapHeadBytes));
  const bool fits = header && CompressionOf(header->compression) &&
                    header->unpacked_size <= kMaxChunkBytes &&
                    header->records_begin + header->packed_size == head->end - head->begin;
  if (!fits) return std::nullopt;
  header->compression = {};
  return header;
}

std::optional<uint64_t> McapScan::FindChunk(uint64_t from) {
  for (; from + kMcapHeadBytes <= source_.size(); ++from) {
    absl::StatusOr<absl::string_view> byte = window_.At(from, 1);
    if (!byte.ok()) return std::nullopt;
    if (static_cast<McapOp>((*byte)[0]) == McapOp::kChunk && ChunkAt(from)) return from;
  }
  return std::nullopt;
}

}  // namespace

bool ScanMcap(const ByteSource& source, BlockFile* file) { return McapScan(source, file).Run(); }

}  // namespace isthmus::readers
