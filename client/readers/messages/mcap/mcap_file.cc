#include "client/readers/messages/mcap/mcap_file.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "client/readers/messages/mcap/mcap_chunks.h"

namespace isthmus::readers {
namespace {

class McapFile : public MessageFile {
 public:
  McapFile(std::shared_ptr<const BlockFile> file, std::vector<std::string> notes)
      : file_(std::move(file)), notes_(std::move(notes)) {}

  std::string kind() const override { return "MCAP"; }
  const std::vector<MessageTopic>& topics() const override { return file_->table.topics; }
  std::vector<std::string> notes() const override { return notes_; }
  absl::StatusOr<std::unique_ptr<MessageReader>> OpenPacked(
      std::vector<size_t> topics) const override {
    return ReadBlocks(file_, topics);
  }

 private:
  const std::shared_ptr<const BlockFile> file_;
  const std::vector<std::string> notes_;
};

void CountByTotals(const std::map<uint32_t, uint64_t>& totals, TopicTable* table) {
  if (totals.empty()) return;
  for (MessageTopic& topic : table->topics) topic.messages = 0;
  for (const auto& [number, total] : totals) {
    const auto topic = table->by_number.find(number);
    if (topic != table->by_number.end()) *table->topics[topic->second].messages += total;
  }
}

}  // namespace

absl::StatusOr<std::shared_ptr<const MessageFile>> OpenMcap(
    std::shared_ptr<const ByteSource> source, const std::string& name) {
  auto file = std::make_shared<BlockFile>();
  file->name = name;
  file->format = std::make_unique<McapBlockFormat>(source);
  std::vector<std::string> notes;
  std::map<uint32_t, uint64_t> totals;
  const absl::Status summary = ReadMcapSummary(*source, file.get(), &totals);
  if (!summary.ok()) {
    file->numbered.clear();
    file->schemas.clear();
    file->blocks.clear();
    const bool ended = ScanMcap(*source, file.get());
    if (!ended || absl::IsDataLoss(summary)) {
      notes.push_back(absl::StrCat(summary.message(), "; it is read as far as it goes"));
    }
  }
  MakeTopicTable(file.get());
  if (summary.ok()) CountByTotals(totals, &file->table);
  for (std::string& note : BlockNotes(*file)) notes.push_back(std::move(note));
  return std::make_shared<McapFile>(std::move(file), std::move(notes));
}

}  // namespace isthmus::readers
