// The metadata.yaml of a ROS 2 bag.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace isthmus::readers {

struct BagMetadata {
  std::vector<std::string> files;  // Names without folders.
  // "FILE", "MESSAGE" or "", and "zstd" or "".
  std::string compression_mode, compression_format;
  std::map<std::string, uint64_t> messages;  // By the name of their topic.
};

// Both the layout up to version 3 (topics_with_message_count, relative_file_paths), which later
// ones keep, and what is missing in it. InvalidArgument for what is no such text.
absl::StatusOr<BagMetadata> ParseBagMetadata(const std::string& yaml);

}  // namespace isthmus::readers
