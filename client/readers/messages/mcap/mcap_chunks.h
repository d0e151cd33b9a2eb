// The chunks of MCAP files: how they are unpacked, and how they are found with and without a
// summary.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "client/readers/messages/block_reader.h"
#include "client/readers/messages/byte_source.h"

namespace isthmus::readers {

// Reads chunks, and messages outside of them. Thread safe.
class McapBlockFormat : public BlockFormat {
 public:
  explicit McapBlockFormat(std::shared_ptr<const ByteSource> source) : source_(std::move(source)) {}
  absl::Status Load(const MessageBlock& block, std::string* content) const override;
  absl::StatusOr<BlockRecord> Parse(absl::string_view content, size_t at) const override;

 private:
  const std::shared_ptr<const ByteSource> source_;
};

// Fills the file by its summary; `totals`: the messages of each channel. NotFound where there is
// none, or none that indexes all chunks, DataLoss where it is damaged
// or cut off.
absl::Status ReadMcapSummary(const ByteSource& source, BlockFile* file,
                             std::map<uint32_t, uint64_t>* totals);

// Fills it by going through the whole file. What cannot be read becomes a damaged block. False
// where the file ends without the mark that a recorder sets when it ends one.
bool ScanMcap(const ByteSource& source, BlockFile* file);

}  // namespace isthmus::readers
