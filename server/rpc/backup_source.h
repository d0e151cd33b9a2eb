// The source of a backup's bytes, which the owner of the store hands to the network skin.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <string>

#include "core/records/backup_contents.h"

namespace isthmus::rpc {

// The sink of a backup; false from either function gives it up.
struct BackupSink {
  std::function<bool(double share)> progress;  // While the copy is made.
  std::function<void(uint64_t size)> begin;    // Size of the bytes that follow.
  std::function<bool(const std::string& piece)> piece;
};

using BackupSource = std::function<absl::StatusOr<BackupContents>(const BackupSink& sink)>;

}  // namespace isthmus::rpc
