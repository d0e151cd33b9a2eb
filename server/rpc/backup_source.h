// The source of a backup's bytes, which the owner of the store hands to the network skin.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <string>

namespace isthmus::rpc {

struct BackupContents {
  int64_t sessions = 0, submaps = 0, scans = 0, points = 0;
  int64_t damaged = 0;  // Records that cannot be read.
  std::string report;   // For people.
};

// The sink of a backup; false from either function gives it up.
struct BackupSink {
  std::function<bool(double share)> progress;  // While the copy is made.
  std::function<void(uint64_t size)> begin;    // Of the bytes that follow.
  std::function<bool(const std::string& piece)> piece;
};

using BackupSource = std::function<absl::StatusOr<BackupContents>(const BackupSink& sink)>;

}  // namespace isthmus::rpc
