// The records of ROS 1 bags.
//
// Source: "Bag File Format, Version 2.0", wiki.ros.org/Bags/Format/2.0: a record is the length of
// its header (uint32), the header, the length of its data (uint32), the data; a header is fields of
// a length (uint32) and NAME=VALUE. Numbers are little endian.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstddef>
#include <cstdint>
#include <optional>

#include "client/readers/messages/block_reader.h"
#include "client/readers/messages/byte_source.h"

namespace isthmus::readers {

inline constexpr absl::string_view kBagMagic = "#ROSBAG V2.0\n";

enum class BagOp : uint8_t {
  kMessage = 2,
  kBag = 3,
  kIndex = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7,
};

// A time as bags write it: seconds in the lower, nanoseconds in the higher 32 bits.
inline int64_t BagTimeNs(uint64_t time) {
  return static_cast<int64_t>(time & 0xFFFFFFFF) * 1'000'000'000 + static_cast<int64_t>(time >> 32);
}

// The fields of a record's header; those that it has not are 0 or empty.
struct BagHeader {
  BagOp op = BagOp::kMessage;
  uint32_t conn = 0;  // Connection.
  uint32_t size = 0;  // A chunk's, once unpacked.
  uint32_t count = 0, conn_count = 0, chunk_count = 0;
  uint64_t time = 0, start_time = 0, end_time = 0;  // As BagTimeNs takes them.
  uint64_t index_pos = 0, chunk_pos = 0;
  absl::string_view compression, topic, encryptor;

  int64_t time_ns() const { return BagTimeNs(time); }
  int64_t start_ns() const { return BagTimeNs(start_time); }
  int64_t end_ns() const { return BagTimeNs(end_time); }
};

// Empty for what is no header: fields that do not fit, no "op" or an unknown one.
std::optional<BagHeader> ParseBagHeader(absl::string_view header);

// A record of a file, without its data. The header's texts are valid until the window moves.
struct BagHead {
  BagHeader header;
  uint64_t data_begin = 0, data_end = 0;  // The file may end before data_end.
};

// DataLoss where no record begins at that byte, or the file ends within the header.
absl::StatusOr<BagHead> ReadBagHead(ByteWindow& window, uint64_t offset);

// The record at byte `at` of a chunk's content.
absl::StatusOr<BlockRecord> ParseBagRecord(absl::string_view content, size_t at);

// The topic that the data of a connection record, with the header's topic, declare.
NumberedTopic ParseConnection(absl::string_view topic, absl::string_view data);

}  // namespace isthmus::readers
