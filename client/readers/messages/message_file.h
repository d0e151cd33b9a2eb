// Files of messages on named topics, as robots record them: bags and MCAP.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/readers/messages/byte_source.h"

namespace isthmus::readers {

struct MessageTopic {
  std::string name;      // "/alice/points"
  std::string type;      // As ROS 1 writes it, whoever recorded: "sensor_msgs/PointCloud2".
  std::string encoding;  // The messages': "ros1", "cdr", "protobuf", ...
  std::optional<uint64_t> messages = std::nullopt;  // Absent if it is not known.
};

struct Message {
  size_t topic = 0;         // Index in MessageFile::topics().
  int64_t log_ns = 0;       // When it was recorded, nanoseconds since the Unix epoch.
  absl::string_view bytes;  // Valid until the next call of the reader.
};

// Holds the chunks whose times overlap, within a limit. Not thread safe.
class MessageReader {
 public:
  virtual ~MessageReader() = default;

  // The next message by the times of recording, as players of recordings give them, whatever the
  // order of the file, unless a clock was set back (FindClockStep); empty after the last one.
  // DataLoss for a damaged stretch, with its bytes and how many messages are lost with it as far as
  // that is known: the next call goes on behind it.
  virtual absl::StatusOr<std::optional<Message>> Next() = 0;

  // As ScanReader's.
  virtual std::vector<std::string> Assumptions() const { return {}; }
};

// Thread safe: readers may be used beside each other.
class MessageFile {
 public:
  virtual ~MessageFile() = default;

  virtual std::string kind() const = 0;  // "ROS 1 bag", "MCAP", "ROS 2 bag (db3)"
  // Each name and type once, sorted by name.
  virtual const std::vector<MessageTopic>& topics() const = 0;
  // Damage and missing parts that showed as it was opened, each a sentence without a full stop.
  virtual std::vector<std::string> notes() const { return {}; }
  // Reads the messages of these topics, skipping parts without any if the file tells. Messages that
  // a recorder compressed one by one come unpacked.
  absl::StatusOr<std::unique_ptr<MessageReader>> OpenReader(std::vector<size_t> topics) const;

 protected:
  // The same, as the messages are in the file.
  virtual absl::StatusOr<std::unique_ptr<MessageReader>> OpenPacked(
      std::vector<size_t> topics) const = 0;
};

// Opens a .bag (or .bag.active), .mcap or .db3, or the folder of a ROS 2 bag. Nothing is written
// beside it. NotFound for what is not there, InvalidArgument, saying what to do, for what is none
// of these or of a kind that is not read (bags 1.x or encrypted, files compressed as a whole).
absl::StatusOr<std::shared_ptr<const MessageFile>> OpenMessageFile(const std::string& path);

// The same of the bytes of a .bag or .mcap. `name` is what messages call it.
absl::StatusOr<std::shared_ptr<const MessageFile>> OpenMessageBytes(
    std::shared_ptr<const ByteSource> source, const std::string& name);

// True if the first bytes, or the files in the folder, are those of a kind of message file, if only
// to be refused by OpenMessageFile with a better message than others could give.
bool IsMessageFile(const std::string& path);

// "sensor_msgs/msg/PointCloud2" as "sensor_msgs/PointCloud2"; others as they are.
std::string ShortType(absl::string_view type);

}  // namespace isthmus::readers
