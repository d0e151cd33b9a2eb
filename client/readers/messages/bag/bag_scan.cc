#include <absl/strings/str_cat.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "client/readers/messages/bag/bag_chunks.h"
#include "client/readers/messages/bag/bag_records.h"
#include "client/readers/messages/limits.h"
#include "core/codec/column.h"

namespace isthmus::readers {
namespace {

// Goes through a bag without an index, record by record.
class BagScan {
 public:
  BagScan(const ByteSource& source, BlockFile* file)
      : source_(source), window_(source, kWindowBytes), file_(file) {}

  void Run() {
    while (at_ < source_.size()) {
      absl::StatusOr<BagHead> head = ReadBagHead(window_, at_);
      if (head.ok()) {
        Take(*head);
      } else {
        LeaveOut(head.status().message());
      }
    }
    // Its index may be cut off.
    LearnLast(/*always=*/true);
  }

 private:
  void Take(const BagHead& head);
  void TakeChunk(const BagHead& head);
  void TakeIndex(const BagHead& head);
  void TakeMessage(const BagHead& head);
  // Notes a damaged block from here to the next chunk.
  void LeaveOut(absl::string_view why, bool may_hold_messages = true);
  std::optional<uint64_t> FindChunk(uint64_t from);
  bool IsChunkWith(uint64_t offset, uint64_t op_offset);
  // Looks into the last chunk where its index does not tell all, or tells of unknown topics.
  void LearnLast(bool always);

  const ByteSource& source_;
  ByteWindow window_;
  BlockFile* const file_;
  uint64_t at_ = kBagMagic.size();
  bool last_is_new_ = false;  // The last block is a chunk that LearnLast has not seen.
};

void BagScan::Take(const BagHead& head) {
  const BagHeader& header = head.header;
  if (header.op == BagOp::kChunk) return TakeChunk(head);
  if (head.data_end > source_.size()) {
    return LeaveOut("the file ends within a record", header.op == BagOp::kMessage);
  }
  if (header.op == BagOp::kIndex) {
    if (last_is_new_) TakeIndex(head);
  } else if (header.op == BagOp::kMessage) {
    TakeMessage(head);
  } else if (header.op == BagOp::kConnection) {
    const std::string topic(header.topic);
    const uint32_t conn = header.conn;
    const uint64_t size = head.data_end - head.data_begin;
    absl::StatusOr<absl::string_view> data = absl::DataLossError("a record is too long");
    if (size <= kMaxSmallRecordBytes) data = window_.At(head.data_begin, size);
    if (!data.ok()) return LeaveOut(data.status().message());
    file_->numbered.emplace(conn, ParseConnection(topic, *data));
  }
  at_ = head.data_end;
}

void BagScan::TakeChunk(const BagHead& head) {
  LearnLast(/*always=*/false);
  const bool open = head.data_end == head.data_begin && head.header.size == 0;
  if (open && head.header.compression == "none") {
    at_ = head.data_end;  // Records follow as they are.
    return;
  }
  const uint64_t end = open ? source_.size() : std::min(head.data_end, source_.size());
  file_->blocks.push_back({.begin = at_, .end = end});
  last_is_new_ = true;
  at_ = end;
}

// Its entries are a time and the place of a message. One that does not fit is of no use: the chunk
// is looked into.
void BagScan::TakeIndex(const BagHead& head) {
  constexpr size_t kEntryBytes = 8 + 4;  // Format
  const BagHeader header = head.header;
  const uint64_t size = head.data_end - head.data_begin;
  if (size / kEntryBytes < header.count || size > kMaxSmallRecordBytes) {
    return LearnLast(/*always=*/true);
  }
  absl::StatusOr<absl::string_view> entries = window_.At(head.data_begin, size);
  if (!entries.ok()) return LearnLast(/*always=*/true);
  for (uint32_t i = 0; i < header.count; ++i) {
    NoteMessage(header.conn, BagTimeNs(codec::LoadAs<uint64_t>(entries->data() + i * kEntryBytes)),
                &file_->blocks.back());
  }
}

void BagScan::TakeMessage(const BagHead& head) {
  LearnLast(/*always=*/false);
  std::vector<MessageBlock>& blocks = file_->blocks;
  if (!GoesOn(*file_, at_, head.header.time_ns())) blocks.push_back({.begin = at_, .loose = true});
  blocks.back().end = head.data_end;
  NoteMessage(head.header.conn, head.header.time_ns(), &blocks.back());
}

void BagScan::LeaveOut(absl::string_view why, bool may_hold_messages) {
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

bool BagScan::IsChunkWith(uint64_t offset, uint64_t op_offset) {
  absl::StatusOr<BagHead> head = ReadBagHead(window_, offset);
  return head.ok() && head->header.op == BagOp::kChunk && op_offset < head->data_begin &&
         head->header.size > 0 && !head->header.compression.empty();
}

std::optional<uint64_t> BagScan::FindChunk(uint64_t from) {
  constexpr absl::string_view kOpField("\x04\0\0\0op=\x05", 8);
  ByteWindow search(source_, kWindowBytes);
  // Chunks are often near: little is read at first.
  for (uint64_t reach = kWindowBytes; from + kOpField.size() <= source_.size();
       reach = std::min<uint64_t>(2 * reach, kSearchBytes)) {
    const uint64_t size = std::min<uint64_t>(reach, source_.size() - from);
    absl::StatusOr<absl::string_view> bytes = search.At(from, size);
    if (!bytes.ok()) return std::nullopt;
    for (size_t hit = bytes->find(kOpField); hit != absl::string_view::npos;
         hit = bytes->find(kOpField, hit + 1)) {
      const uint64_t op = from + hit;
      const uint64_t lowest = std::max(at_ + 1, op - std::min<uint64_t>(op, kChunkHeadBytes));
      for (uint64_t offset = lowest; offset < op; ++offset) {
        if (IsChunkWith(offset, op)) return offset;
      }
    }
    if (size < reach) break;
    from += size - kOpField.size() + 1;
  }
  return std::nullopt;
}

void BagScan::LearnLast(bool always) {
  if (!std::exchange(last_is_new_, false)) return;
  LearnUnlessKnown(always, file_->blocks.back(), file_);
}

}  // namespace

void ScanBag(const ByteSource& source, BlockFile* file) { BagScan(source, file).Run(); }

}  // namespace isthmus::readers
