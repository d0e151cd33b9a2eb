// A backup as bytes, for callers that have no folder on this machine.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <string>

#include "storage/upkeep/backup.h"

namespace isthmus::storage {

struct BackupReader {
  BackupProgress progress = {};  // Progress of the copy; may be empty.
  // Called once the copy is made, with the bytes that follow.
  std::function<void(uint64_t size)> begin = {};
  // The database, piece by piece; false gives up.
  std::function<bool(const std::string& piece)> piece = {};
};

// Makes a backup within `directory`, see BackUp, hands its isthmus.db to `reader` and removes it
// again: for so long the disk needs as much room again. Errors are BackUp's; Cancelled when the
// reader gave up, Unavailable when the copy cannot be read back.
absl::StatusOr<StoreReport> StreamBackup(const std::string& directory, const BackupReader& reader);

// Removes the files that StreamBackup left in the folder when its process died. For a caller that
// holds the folder's lock and has begun no backup.
void RemoveAbandonedBackups(const std::string& directory);

}  // namespace isthmus::storage
