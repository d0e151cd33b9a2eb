#include "client/readers/messages/bag/bag_file.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "client/readers/messages/bag/bag_chunks.h"
#include "client/readers/messages/bag/bag_records.h"
#include "client/readers/messages/limits.h"

namespace isthmus::readers {
namespace {

class BagFile : public MessageFile {
 public:
  BagFile(std::shared_ptr<const BlockFile> file, std::vector<std::string> notes)
      : file_(std::move(file)), notes_(std::move(notes)) {}

  std::string kind() const override { return "ROS 1 bag"; }
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

// A note on an index that could not be read; empty if it could.
std::string ReadIndex(const ByteSource& source, BlockFile* file, absl::Status* refused) {
  ByteWindow window(source, kWindowBytes);
  absl::StatusOr<BagHead> head = ReadBagHead(window, kBagMagic.size());
  if (!head.ok() || head->header.op != BagOp::kBag) return "the head of the bag is damaged";
  if (!head->header.encryptor.empty()) {
    *refused = absl::InvalidArgumentError(absl::StrCat(file->name, " is encrypted (",
                                                       head->header.encryptor,
                                                       "): decrypt it with `rosbag decrypt`"));
    return {};
  }
  const BagHeader header = head->header;
  constexpr char kNoIndex[] =
      "the bag has no index, and nothing tells how many messages are missing";
  if (header.index_pos == 0) return absl::StrCat("the recording was not ended: ", kNoIndex);
  if (header.index_pos > source.size()) {
    return absl::StrCat("the file is cut off at byte ", source.size(), ": ", kNoIndex);
  }
  absl::Status status =
      ReadBagIndex(source, header.index_pos, header.conn_count, header.chunk_count, file);
  if (status.ok()) return {};
  file->numbered.clear();
  file->blocks.clear();
  return absl::StrCat("the index of the bag cannot be read (", status.message(), ")");
}

}  // namespace

absl::StatusOr<std::shared_ptr<const MessageFile>> OpenBag(std::shared_ptr<const ByteSource> source,
                                                           const std::string& name) {
  auto file = std::make_shared<BlockFile>();
  file->name = name;
  file->format = std::make_unique<BagBlockFormat>(source);
  absl::Status refused;
  std::vector<std::string> notes;
  if (std::string note = ReadIndex(*source, file.get(), &refused); !note.empty()) {
    notes.push_back(note + "; it is read as far as it goes");
    ScanBag(*source, file.get());
  }
  if (!refused.ok()) return refused;
  MakeTopicTable(file.get());
  for (std::string& note : BlockNotes(*file)) notes.push_back(std::move(note));
  return std::make_shared<BagFile>(std::move(file), std::move(notes));
}

}  // namespace isthmus::readers
