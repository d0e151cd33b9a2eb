#include "client/readers/messages/block_reader.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "client/readers/messages/limits.h"

namespace isthmus::readers {
namespace {

// A wanted message of a block that is loaded.
struct Entry {
  int64_t log_ns = 0;
  size_t at = 0;  // Byte of the content.
};

// A block whose messages are being given.
struct OpenBlock {
  size_t given = 0;  // Messages.
  bool loaded = false;
  std::string content;
  std::vector<Entry> entries;  // By their time, then their place.
  std::string cut;             // Why there are no more than these; empty where they are all.

  uint64_t bytes() const { return content.size() + entries.size() * sizeof(Entry); }
  void Drop() {
    loaded = false;
    content = std::string();
    entries = std::vector<Entry>();
  }
};

class BlockReader : public MessageReader {
 public:
  BlockReader(std::shared_ptr<const BlockFile> file, const std::vector<size_t>& topics)
      : file_(std::move(file)) {
    const std::set<size_t> wanted(topics.begin(), topics.end());
    for (const auto& [number, topic] : file_->table.by_number) {
      if (wanted.contains(topic)) topic_of_.emplace(number, topic);
    }
    SortBlocks();
  }

  absl::StatusOr<std::optional<Message>> Next() override;

 private:
  // When the next message of an open block was recorded, and the number of the block.
  using Due = std::pair<int64_t, size_t>;

  // Lists the blocks with wanted messages by when they begin: one that does not tell when, as the
  // one before it in the file.
  void SortBlocks();
  bool Skips(const MessageBlock& block) const;
  // Opens the next block of that list.
  absl::Status Open();
  absl::Status Load(const MessageBlock& block, OpenBlock* open) const;
  // Puts an open block where its next message is due; its damage where it has no more.
  absl::Status PutBack(size_t number, OpenBlock open);
  // Drops what is held beyond kMaxOpenBytes, but for the block that is due.
  void MakeRoom();
  // A damage of a block, of which so many wanted messages were given.
  absl::Status Damage(const MessageBlock& block, uint64_t given, absl::string_view why) const;

  const std::shared_ptr<const BlockFile> file_;
  std::map<uint32_t, size_t> topic_of_;
  std::vector<Due> order_;  // Blocks, by their first time.
  size_t next_ = 0;         // In order_.
  std::map<Due, OpenBlock> open_;
  uint64_t held_ = 0;           // Bytes of open_.
  std::optional<size_t> last_;  // The block of the last message.
  OpenBlock last_open_;         // Holds its bytes.
};

void BlockReader::SortBlocks() {
  int64_t first_ns = std::numeric_limits<int64_t>::min();
  for (size_t i = 0; i < file_->blocks.size(); ++i) {
    const MessageBlock& block = file_->blocks[i];
    first_ns = block.first_ns.value_or(first_ns);
    if (!Skips(block)) order_.emplace_back(first_ns, i);
  }
  std::sort(order_.begin(), order_.end());
}

bool BlockReader::Skips(const MessageBlock& block) const {
  if (!block.counts) return false;
  return std::none_of(block.counts->begin(), block.counts->end(), [&](const auto& count) {
    return count.second > 0 && topic_of_.contains(count.first);
  });
}

absl::Status BlockReader::Damage(const MessageBlock& block, uint64_t given,
                                 absl::string_view why) const {
  std::string lost;
  if (block.counts && block.counted) {
    uint64_t there = 0;
    for (const auto& [number, count] : *block.counts) {
      if (topic_of_.contains(number)) there += count;
    }
    lost = absl::StrCat(" (messages lost: ", there - std::min(there, given), " of ", there, ")");
  }
  return absl::DataLossError(absl::StrCat(file_->name, ": bytes ", block.begin, " to ", block.end,
                                          " cannot be read", lost, ": ", why));
}

absl::Status BlockReader::Load(const MessageBlock& block, OpenBlock* open) const {
  const absl::Status loaded = file_->format->Load(block, &open->content);
  // A block that ends too early can be read up to there.
  if (!loaded.ok() && !absl::IsOutOfRange(loaded)) return loaded;
  open->cut = std::string(loaded.message());
  open->entries.clear();
  for (size_t at = 0; at < open->content.size();) {
    absl::StatusOr<BlockRecord> record = file_->format->Parse(open->content, at);
    if (!record.ok()) {
      if (open->cut.empty()) open->cut = std::string(record.status().message());
      break;
    }
    if (record->is_message && topic_of_.contains(record->number)) {
      open->entries.push_back({record->log_ns, at});
    }
    at = record->end;
  }
  const auto key = [](const Entry& entry) { return std::pair(entry.log_ns, entry.at); };
  std::sort(open->entries.begin(), open->entries.end(),
            [&](const Entry& a, const Entry& b) { return key(a) < key(b); });
  open->loaded = true;
  return absl::OkStatus();
}

absl::Status BlockReader::Open() {
  const size_t number = order_[next_++].second;
  const MessageBlock& block = file_->blocks[number];
  if (!block.damage.empty()) return Damage(block, 0, block.damage);
  OpenBlock open;
  if (absl::Status loaded = Load(block, &open); !loaded.ok()) {
    return Damage(block, 0, loaded.message());
  }
  return PutBack(number, std::move(open));
}

absl::Status BlockReader::PutBack(size_t number, OpenBlock open) {
  if (open.given >= open.entries.size()) {
    if (open.cut.empty()) return absl::OkStatus();
    return Damage(file_->blocks[number], open.given, open.cut);
  }
  held_ += open.bytes();
  open_.emplace(Due{open.entries[open.given].log_ns, number}, std::move(open));
  if (held_ > kMaxOpenBytes) MakeRoom();
  return absl::OkStatus();
}

void BlockReader::MakeRoom() {
  for (auto late = std::prev(open_.end()); late != open_.begin() && held_ > kMaxOpenBytes; --late) {
    held_ -= late->second.bytes();
    late->second.Drop();
  }
}

absl::StatusOr<std::optional<Message>> BlockReader::Next() {
  if (last_) {
    const size_t number = *std::exchange(last_, std::nullopt);
    if (auto status = PutBack(number, std::move(last_open_)); !status.ok()) return status;
  }
  while (next_ < order_.size() && (open_.empty() || order_[next_] <= open_.begin()->first)) {
    if (absl::Status status = Open(); !status.ok()) return status;
  }
  if (open_.empty()) return std::nullopt;
  auto due = open_.extract(open_.begin());
  const size_t number = due.key().second;
  held_ -= due.mapped().bytes();
  last_open_ = std::move(due.mapped());
  const MessageBlock& block = file_->blocks[number];
  if (!last_open_.loaded) {
    const absl::Status loaded = Load(block, &last_open_);
    if (!loaded.ok()) return Damage(block, last_open_.given, loaded.message());
  }
  if (last_open_.given >= last_open_.entries.size()) {
    return Damage(block, last_open_.given, "the file has changed");
  }
  const Entry& entry = last_open_.entries[last_open_.given++];
  absl::StatusOr<BlockRecord> record = file_->format->Parse(last_open_.content, entry.at);
  if (!record.ok()) return Damage(block, last_open_.given, record.status().message());
  last_ = number;
  return Message{topic_of_.at(record->number), record->log_ns, record->bytes};
}

}  // namespace

std::unique_ptr<MessageReader> ReadBlocks(std::shared_ptr<const BlockFile> file,
                                          const std::vector<size_t>& topics) {
  return std::make_unique<BlockReader>(std::move(file), topics);
}

}  // namespace isthmus::readers
