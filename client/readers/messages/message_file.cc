#include "client/readers/messages/message_file.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_replace.h>

#include <algorithm>
#include <filesystem>

#include "client/readers/messages/bag/bag_file.h"
#include "client/readers/messages/bag/bag_records.h"
#include "client/readers/messages/db3/bag_folder.h"
#include "client/readers/messages/db3/db3_file.h"
#include "client/readers/messages/mcap/mcap_file.h"
#include "client/readers/messages/mcap/mcap_records.h"
#include "client/readers/messages/unpack.h"

namespace isthmus::readers {
namespace {

namespace fs = std::filesystem;

constexpr absl::string_view kAnyBagMagic = "#ROSBAG V";
constexpr absl::string_view kSqliteMagic("SQLite format 3\0", 16);

std::string FirstBytes(const ByteSource& source) {
  std::string bytes(std::min<uint64_t>(source.size(), kSqliteMagic.size()), '\0');
  return source.Read(0, bytes.size(), bytes.data()).ok() ? bytes : std::string();
}

class UnpackingReader : public MessageReader {
 public:
  UnpackingReader(std::vector<MessageTopic> topics, std::unique_ptr<MessageReader> packed)
      : topics_(std::move(topics)), packed_(std::move(packed)) {}

  absl::StatusOr<std::optional<Message>> Next() override {
    absl::StatusOr<std::optional<Message>> message = packed_->Next();
    if (!message.ok() || !message->has_value()) return message;
    const MessageTopic& topic = topics_[(*message)->topic];
    absl::StatusOr<absl::string_view> bytes =
        UnpackedMessage(topic.encoding, (*message)->bytes, &content_);
    if (!bytes.ok()) {
      return absl::DataLossError(absl::StrCat("a message of ", topic.name,
                                              " cannot be unpacked: ", bytes.status().message()));
    }
    (*message)->bytes = *bytes;
    return message;
  }
  std::vector<std::string> Assumptions() const override { return packed_->Assumptions(); }

 private:
  const std::vector<MessageTopic> topics_;
  const std::unique_ptr<MessageReader> packed_;
  std::string content_;
};

bool IsZstdBag(absl::string_view first, const std::string& path) {
  return absl::StartsWith(first, kZstdMagic) &&
         (absl::EndsWith(path, ".db3.zstd") || absl::EndsWith(path, ".mcap.zstd"));
}

absl::Status NotMessages(const std::string& name) {
  return absl::InvalidArgumentError(
      absl::StrCat(name, " is no recording of messages: neither a ROS bag nor MCAP"));
}

}  // namespace

absl::StatusOr<std::unique_ptr<MessageReader>> MessageFile::OpenReader(
    std::vector<size_t> topics) const {
  absl::StatusOr<std::unique_ptr<MessageReader>> packed = OpenPacked(std::move(topics));
  if (!packed.ok()) return packed.status();
  return std::make_unique<UnpackingReader>(this->topics(), *std::move(packed));
}

absl::StatusOr<std::shared_ptr<const MessageFile>> OpenMessageBytes(
    std::shared_ptr<const ByteSource> source, const std::string& name) {
  const std::string first = FirstBytes(*source);
  if (absl::StartsWith(first, kBagMagic)) return OpenBag(std::move(source), name);
  if (absl::StartsWith(first, kMcapMagic)) return OpenMcap(std::move(source), name);
  if (absl::StartsWith(first, kAnyBagMagic)) {
    return absl::InvalidArgumentError(absl::StrCat(
        name, " is a ROS bag of an old version; make one of version 2.0 with `rosbag migrate`"));
  }
  if (IsZstdBag(first, name)) {
    return absl::InvalidArgumentError(absl::StrCat(
        name, " is compressed as a whole; unpack it first, with `zstd -d ", name, "`"));
  }
  return NotMessages(name);
}

absl::StatusOr<std::shared_ptr<const MessageFile>> OpenMessageFile(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return OpenBagFolder(path);
  absl::StatusOr<std::shared_ptr<const ByteSource>> source = OpenFileSource(path);
  if (!source.ok()) return source.status();
  if (absl::StartsWith(FirstBytes(**source), kSqliteMagic)) return OpenDb3(path);
  return OpenMessageBytes(*std::move(source), path);
}

bool IsMessageFile(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return IsBagFolder(path);
  if (!fs::is_regular_file(path, error)) return false;
  absl::StatusOr<std::shared_ptr<const ByteSource>> source = OpenFileSource(path);
  if (!source.ok()) return false;
  const std::string first = FirstBytes(**source);
  return absl::StartsWith(first, kAnyBagMagic) || absl::StartsWith(first, kMcapMagic) ||
         absl::StartsWith(first, kSqliteMagic) || IsZstdBag(first, path);
}

std::string ShortType(absl::string_view type) {
  return absl::StrReplaceAll(type, {{"::", "/"}, {"/msg/", "/"}, {"::msg::", "/"}});
}

}  // namespace isthmus::readers
