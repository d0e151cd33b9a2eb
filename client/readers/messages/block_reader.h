// The part of reading messages that bags and MCAP have in common: blocks of records, one by one.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "client/readers/messages/byte_source.h"
#include "client/readers/messages/message_file.h"

namespace isthmus::readers {

// A chunk, a stretch of messages outside of chunks, or a stretch that is damaged.
struct MessageBlock {
  uint64_t begin = 0, end = 0;  // Bytes of the file; for a chunk, its whole record.
  bool loose = false;           // Not a chunk: the bytes are records as they are.
  std::string damage = {};      // Empty unless the stretch is damaged.
  // Times of recording of its first and its last message; absent if nothing tells.
  std::optional<int64_t> first_ns = std::nullopt, last_ns = std::nullopt;
  // Messages by the file's number of connection or channel; absent if nothing tells.
  std::optional<std::map<uint32_t, uint64_t>> counts = std::nullopt;
  bool counted = true;  // Else `counts` only tells whose messages there are, of some of them.
};

// A topic of a file, by the file's number of connection or channel.
struct NumberedTopic {
  std::string name, type, encoding;
  uint32_t schema = 0;  // Its name is the type if `type` is empty.
};

// A record inside a block.
struct BlockRecord {
  // Bytes of the block behind it.
  size_t end = 0;
  bool is_message = false;
  uint32_t number = 0;  // The connection's or channel's.
  int64_t log_ns = 0;
  absl::string_view bytes;
  // The topic that a connection or channel record declares, under `number`.
  std::optional<NumberedTopic> declared = std::nullopt;
  std::string schema = {};  // The name that a schema record declares, under `number`.
};

// A format's way to pack blocks. Thread safe.
class BlockFormat {
 public:
  virtual ~BlockFormat() = default;
  // Reads and unpacks a block. Errors of Unpack and of ByteSource.
  virtual absl::Status Load(const MessageBlock& block, std::string* content) const = 0;
  // The record that begins at byte `at` of a block's content; DataLoss for what is none.
  virtual absl::StatusOr<BlockRecord> Parse(absl::string_view content, size_t at) const = 0;
};

// All topics of a file, each name and type once, and how its numbers map onto them.
struct TopicTable {
  std::vector<MessageTopic> topics;
  std::map<uint32_t, size_t> by_number;
};

// A file that was opened, as its readers share it.
struct BlockFile {
  std::string name;  // Its name in messages.
  std::unique_ptr<const BlockFormat> format;
  std::map<uint32_t, NumberedTopic> numbered;
  std::map<uint32_t, std::string> schemas;
  std::set<uint32_t> undeclared;  // Numbers that were looked for in vain.
  std::vector<MessageBlock> blocks;
  TopicTable table;
};

// Takes a message of that number into what is known of the block.
void NoteMessage(uint32_t number, int64_t log_ns, MessageBlock* block);

// True where a message outside of chunks goes into the file's last block, which ends where it
// begins and holds none that was recorded so much later that a clock may have been set between.
bool GoesOn(const BlockFile& file, uint64_t begin, int64_t log_ns);

// Looks into a block of the file: counts its messages, notes their times, and takes the
// topics and schemas that it declares. What cannot be read leaves the counts absent, or those of
// the messages before it.
void LearnBlock(MessageBlock& block, BlockFile* file);

// The same, unless its counts and its times are there and all of its topics known, or `always`.
void LearnUnlessKnown(bool always, MessageBlock& block, BlockFile* file);

// Fills the table by the file's numbers, schemas and blocks. Where one block does not tell, the
// messages of no topic are counted.
void MakeTopicTable(BlockFile* file);

// Notes on damage, and on messages that belong to no topic that is declared, for
// MessageFile::notes.
std::vector<std::string> BlockNotes(const BlockFile& file);

// A reader of these topics (of BlockFile::table), by the times of recording whatever the order of
// the file, on either side of where a clock was set (FindClockStep); messages of one time come in
// the file's order. A block is loaded when a message in it may be the next one. Where the times of
// many overlap, those whose next message is late are given up beyond kMaxOpenBytes, and loaded
// again when it is due. Damage is reported where the messages before it end.
std::unique_ptr<MessageReader> ReadBlocks(std::shared_ptr<const BlockFile> file,
                                          const std::vector<size_t>& topics);

}  // namespace isthmus::readers
