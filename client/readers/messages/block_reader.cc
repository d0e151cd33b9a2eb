#include "client/readers/messages/block_reader.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <compare>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "client/readers/messages/clock_step.h"
#include "client/readers/messages/limits.h"

namespace isthmus::readers {
namespace {

// When a message comes: behind a step of the clock, and when it was recorded.
struct Instant {
  bool is_behind = false;
  int64_t log_ns = 0;
  auto operator<=>(const Instant&) const = default;
};

// A wanted message of a block that is loaded.
struct Entry {
  Instant when;
  size_t at = 0;  // Byte of the content.
  auto operator<=>(const Entry&) const = default;
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
  std::vector<std::string> Assumptions() const override {
    return step_ ? std::vector<std::string>{step_->Text()} : std::vector<std::string>();
  }

 private:
  // When the next message of an open block comes, and the number of the block.
  using Due = std::pair<Instant, size_t>;

  // Lists the blocks with wanted messages by when they begin: one that does not tell when, as the
  // one before it in the file.
  void SortBlocks();
  bool Skips(const MessageBlock& block) const;
  // Looks for a step of the clock in the blocks with wanted messages, in the order of the file.
  void FindStep(std::vector<size_t> blocks);
  // Tells which of a block's messages, in its order, are behind the step.
  void MarkBehind(size_t number, std::vector<Entry>& entries);
  // Opens the next block of that list.
  absl::Status Open();
  absl::Status Load(size_t number, OpenBlock* open);
  // Puts an open block where its next message is due; its damage where it has no more.
  absl::Status PutBack(size_t number, OpenBlock open);
  // Drops what is held beyond kMaxOpenBytes, but for the block that is due.
  void MakeRoom();
  // A damage of a block, of which so many wanted messages were given.
  absl::Status Damage(const MessageBlock& block, uint64_t given, absl::string_view why) const;

  const std::shared_ptr<const BlockFile> file_;
  std::map<uint32_t, size_t> topic_of_;
  std::vector<Due> order_;  // Blocks, by their first time.
  std::optional<ClockStep> step_;
  // Bytes of the file from which on all is behind the step, and from which on some may be; where
  // the clock was set.
  uint64_t behind_ = std::numeric_limits<uint64_t>::max(), step_at_ = behind_;
  size_t next_ = 0;  // In order_.
  std::map<Due, OpenBlock> open_;
  uint64_t held_ = 0;           // Bytes of open_.
  std::optional<size_t> last_;  // The block of the last message.
  OpenBlock last_open_;         // Holds its bytes.
};

void BlockReader::SortBlocks() {
  std::vector<size_t> wanted;
  for (size_t i = 0; i < file_->blocks.size(); ++i) {
    if (!Skips(file_->blocks[i])) wanted.push_back(i);
  }
  FindStep(wanted);
  int64_t first_ns = std::numeric_limits<int64_t>::min();
  for (const size_t i : wanted) {
    const MessageBlock& block = file_->blocks[i];
    first_ns = block.first_ns.value_or(first_ns);
    order_.emplace_back(Instant{block.begin >= behind_, first_ns}, i);
  }
  std::sort(order_.begin(), order_.end());
}

void BlockReader::FindStep(std::vector<size_t> blocks) {
  // A chunk without messages has times of 0.
  std::erase_if(blocks, [&](size_t i) { return file_->blocks[i].last_ns.value_or(0) == 0; });
  std::sort(blocks.begin(), blocks.end(),
            [&](size_t a, size_t b) { return file_->blocks[a].begin < file_->blocks[b].begin; });
  std::vector<LogSpan> spans;
  for (const size_t i : blocks) {
    spans.push_back({*file_->blocks[i].first_ns, *file_->blocks[i].last_ns});
  }
  step_ = FindClockStep(spans);
  if (!step_ || !step_->was_set) return;
  step_at_ = file_->blocks[blocks[step_->at]].begin;
  behind_ = step_->is_within ? file_->blocks[blocks[step_->at + 1]].begin : step_at_;
}

void BlockReader::MarkBehind(size_t number, std::vector<Entry>& entries) {
  const uint64_t begin = file_->blocks[number].begin;
  size_t from = begin >= behind_ ? 0 : entries.size();
  if (begin >= step_at_ && begin < behind_) {
    for (from = 1; from < entries.size(); ++from) {
      if (GoesBack(entries[from - 1].when.log_ns, entries[from].when.log_ns)) break;
    }
  } else if (order_.size() == 1) {
    std::vector<LogSpan> spans;
    for (const Entry& entry : entries) spans.push_back({entry.when.log_ns, entry.when.log_ns});
    step_ = FindClockStep(spans);
    if (step_ && step_->was_set) from = step_->at;
  }
  for (size_t i = from; i < entries.size(); ++i) entries[i].when.is_behind = true;
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
  } else {
    lost = given == 0 ? " (how many messages are lost is not known)"
                      : absl::StrCat(" as a whole (messages read: ", given,
                                     "; how many are lost is not known)");
  }
  return absl::DataLossError(absl::StrCat(file_->name, ": bytes ", block.begin, " to ", block.end,
                                          " cannot be read", lost, ": ", why));
}

absl::Status BlockReader::Load(size_t number, OpenBlock* open) {
  const absl::Status loaded = file_->format->Load(file_->blocks[number], &open->content);
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
      open->entries.push_back({{false, record->log_ns}, at});
    }
    at = record->end;
  }
  MarkBehind(number, open->entries);
  std::sort(open->entries.begin(), open->entries.end());
  open->loaded = true;
  return absl::OkStatus();
}

absl::Status BlockReader::Open() {
  const size_t number = order_[next_++].second;
  const MessageBlock& block = file_->blocks[number];
  if (!block.damage.empty()) return Damage(block, 0, block.damage);
  OpenBlock open;
  if (absl::Status loaded = Load(number, &open); !loaded.ok()) {
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
  open_.emplace(Due{open.entries[open.given].when, number}, std::move(open));
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
    const absl::Status loaded = Load(number, &last_open_);
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
