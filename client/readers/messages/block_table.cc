#include <absl/strings/str_cat.h>

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

#include "client/readers/messages/block_reader.h"
#include "client/readers/messages/clock_step.h"
#include "client/readers/messages/limits.h"

namespace isthmus::readers {

void NoteMessage(uint32_t number, int64_t log_ns, MessageBlock* block) {
  if (!block->counts) block->counts.emplace();
  ++(*block->counts)[number];
  block->first_ns = std::min(block->first_ns.value_or(log_ns), log_ns);
  block->last_ns = std::max(block->last_ns.value_or(log_ns), log_ns);
}

bool GoesOn(const BlockFile& file, uint64_t begin, int64_t log_ns) {
  if (file.blocks.empty()) return false;
  const MessageBlock& last = file.blocks.back();
  return last.loose && last.end == begin && last.end - last.begin <= kLooseBlockBytes &&
         !GoesBack(last.last_ns.value_or(log_ns), log_ns);
}

void LearnBlock(MessageBlock& block, BlockFile* file) {
  std::string content;
  block.counts.reset();
  block.first_ns.reset();
  block.last_ns.reset();
  const absl::Status loaded = file->format->Load(block, &content);
  if (!loaded.ok() && !absl::IsOutOfRange(loaded)) return;
  block.counts.emplace();
  block.counted = false;
  for (size_t at = 0; at < content.size();) {
    absl::StatusOr<BlockRecord> record = file->format->Parse(content, at);
    if (!record.ok()) return;
    if (record->declared) file->numbered.emplace(record->number, *std::move(record->declared));
    if (!record->schema.empty()) file->schemas.emplace(record->number, std::move(record->schema));
    if (record->is_message) NoteMessage(record->number, record->log_ns, &block);
    at = record->end;
  }
  block.counted = loaded.ok();
}

void LearnUnlessKnown(bool always, MessageBlock& block, BlockFile* file) {
  const auto known = [&](const auto& count) {
    return file->numbered.contains(count.first) || file->undeclared.contains(count.first);
  };
  if (!always && block.counts && block.first_ns &&
      std::all_of(block.counts->begin(), block.counts->end(), known)) {
    return;
  }
  LearnBlock(block, file);
  if (!block.counts) return;
  // They are declared with their first message: what is lost is not looked for in every chunk.
  for (const auto& count : *block.counts) {
    if (!file->numbered.contains(count.first)) file->undeclared.insert(count.first);
  }
}

void MakeTopicTable(BlockFile* file) {
  TopicTable& table = file->table;
  std::map<std::tuple<std::string, std::string, std::string>, std::vector<uint32_t>> sorted;
  for (auto& [number, topic] : file->numbered) {
    if (topic.type.empty()) topic.type = file->schemas[topic.schema];
    sorted[{topic.name, ShortType(topic.type), topic.encoding}].push_back(number);
  }
  for (const auto& [names, numbers] : sorted) {
    for (const uint32_t number : numbers) table.by_number.emplace(number, table.topics.size());
    table.topics.push_back({std::get<0>(names), std::get<1>(names), std::get<2>(names)});
  }
  for (const MessageBlock& block : file->blocks) {
    if (!block.counts || !block.counted) return;
  }
  for (MessageTopic& topic : table.topics) topic.messages = 0;
  for (const MessageBlock& block : file->blocks) {
    for (const auto& [number, count] : *block.counts) {
      const auto topic = table.by_number.find(number);
      if (topic != table.by_number.end()) *table.topics[topic->second].messages += count;
    }
  }
}

std::vector<std::string> BlockNotes(const BlockFile& file) {
  std::vector<std::string> notes;
  size_t more = 0;
  std::set<uint32_t> undeclared;
  for (const MessageBlock& block : file.blocks) {
    if (block.counts) {
      for (const auto& count : *block.counts) {
        if (!file.numbered.contains(count.first)) undeclared.insert(count.first);
      }
    }
    if (block.damage.empty()) continue;
    if (notes.size() == kMaxNotedDamages) {
      ++more;
      continue;
    }
    notes.push_back(absl::StrCat("bytes ", block.begin, " to ", block.end,
                                 " are damaged and left out: ", block.damage));
  }
  if (more > 0) notes.push_back(absl::StrCat("so are ", more, " more stretches"));
  if (!undeclared.empty()) {
    notes.push_back(absl::StrCat("the names of ", undeclared.size(),
                                 " topics are lost, and their messages left out"));
  }
  return notes;
}

}  // namespace isthmus::readers
