// The chunks of ROS 1 bags: how they are unpacked, and how they are found with and without an
// index.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "client/readers/messages/block_reader.h"
#include "client/readers/messages/byte_source.h"

namespace isthmus::readers {

// Reads chunks, and messages outside of them, of bag format 2.0. Thread safe.
class BagBlockFormat : public BlockFormat {
 public:
  explicit BagBlockFormat(std::shared_ptr<const ByteSource> source) : source_(std::move(source)) {}
  absl::Status Load(const MessageBlock& block, std::string* content) const override;
  absl::StatusOr<BlockRecord> Parse(absl::string_view content, size_t at) const override;

 private:
  absl::Status LoadChunk(const MessageBlock& block, std::string* content) const;

  const std::shared_ptr<const ByteSource> source_;
};

// Fills numbered and blocks by the index that begins at byte index_pos. DataLoss where it is cut
// off, damaged, or has not the numbers of connections and chunks that the bag's header says.
absl::Status ReadBagIndex(const ByteSource& source, uint64_t index_pos, uint32_t connections,
                          uint32_t chunks, BlockFile* file);

// Fills them by going through the whole bag. What cannot be read becomes a damaged block.
void ScanBag(const ByteSource& source, BlockFile* file);

}  // namespace isthmus::readers
