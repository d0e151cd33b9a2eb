#include "client/readers/messages/block_reader.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <set>
#include <utility>

#include "client/readers/messages/limits.h"

namespace isthmus::readers {
namespace {

class BlockReader : public MessageReader {
 public:
  BlockReader(std::shared_ptr<const BlockFile> file, const std::vector<size_t>& topics)
      : file_(std::move(file)) {
    const std::set<size_t> wanted(topics.begin(), topics.end());
    for (const auto& [number, topic] : file_->table.by_number) {
      if (wanted.contains(topic)) topic_of_.emplace(number, topic);
    }
  }

  absl::StatusOr<std::optional<Message>> Next() override;

 private:
  // Opens the next block with wanted messages; false behind the last one.
  absl::StatusOr<bool> Open();
  bool Skips(const MessageBlock& block) const;
  // A damage of the block that is open, of which so many wanted messages were given.
  absl::Status Damage(const MessageBlock& block, absl::string_view why) const;

  const std::shared_ptr<const BlockFile> file_;
  std::map<uint32_t, size_t> topic_of_;
  size_t next_block_ = 0;
  const MessageBlock* block_ = nullptr;  // The one that is open.
  std::string content_;
  std::string cut_;  // Why the content is not all of the block; empty if it is.
  size_t at_ = 0;
  uint64_t given_ = 0;
};

bool BlockReader::Skips(const MessageBlock& block) const {
  if (!block.counts) return false;
  return std::none_of(block.counts->begin(), block.counts->end(), [&](const auto& count) {
    return count.second > 0 && topic_of_.contains(count.first);
  });
}

absl::Status BlockReader::Damage(const MessageBlock& block, absl::string_view why) const {
  std::string lost;
  if (block.counts && block.counted) {
    uint64_t there = 0;
    for (const auto& [number, count] : *block.counts) {
      if (topic_of_.contains(number)) there += count;
    }
    lost = absl::StrCat(" (messages lost: ", there - std::min(there, given_), " of ", there, ")");
  }
  return absl::DataLossError(absl::StrCat(file_->name, ": bytes ", block.begin, " to ", block.end,
                                          " cannot be read", lost, ": ", why));
}

absl::StatusOr<bool> BlockReader::Open() {
  block_ = nullptr;
  while (next_block_ < file_->blocks.size()) {
    const MessageBlock& block = file_->blocks[next_block_++];
    if (Skips(block)) continue;
    given_ = 0;
    if (!block.damage.empty()) return Damage(block, block.damage);
    const absl::Status loaded = file_->format->Load(block, &content_);
    // What ends too early can be read up to there.
    if (!loaded.ok() && !absl::IsOutOfRange(loaded)) return Damage(block, loaded.message());
    cut_ = std::string(loaded.message());
    at_ = 0;
    block_ = &block;
    return true;
  }
  return false;
}

absl::StatusOr<std::optional<Message>> BlockReader::Next() {
  while (true) {
    if (block_ == nullptr) {
      absl::StatusOr<bool> opened = Open();
      if (!opened.ok()) return opened.status();
      if (!*opened) return std::nullopt;
    }
    const MessageBlock& block = *block_;
    if (at_ >= content_.size()) {
      block_ = nullptr;
      if (!cut_.empty()) return Damage(block, cut_);
      continue;
    }
    absl::StatusOr<BlockRecord> record = file_->format->Parse(content_, at_);
    if (!record.ok()) {
      block_ = nullptr;
      return Damage(block, cut_.empty() ? record.status().message() : cut_);
    }
    at_ = record->end;
    if (!record->is_message) continue;
    const auto topic = topic_of_.find(record->number);
    if (topic == topic_of_.end()) continue;
    ++given_;
    return Message{topic->second, record->log_ns, record->bytes};
  }
}

}  // namespace

std::unique_ptr<MessageReader> ReadBlocks(std::shared_ptr<const BlockFile> file,
                                          const std::vector<size_t>& topics) {
  return std::make_unique<BlockReader>(std::move(file), topics);
}

}  // namespace isthmus::readers
