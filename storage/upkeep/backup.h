// A copy of a map folder, made while it is in use.
#pragma once

#include <absl/status/statusor.h>

#include <functional>
#include <string>

#include "storage/upkeep/check_store.h"

namespace isthmus::storage {

// Called now and then with the share that is copied, 0 to 1; false gives up.
using BackupProgress = std::function<bool(double share)>;

// Copies the map in `directory` as of one commit, the last before the call, to the new folder
// `target`, and reads the copy from end to end. The report lists its contents; damage there is of
// the map itself or of the copy's disk, and no reason not to keep the copy. To restore is to open
// `target`, or a copy of it, as a map folder.
//
// Readers and writers, of this process or another, go on meanwhile; the write-ahead log grows by
// what they write, as it cannot be begun anew before the copy is made. `target` appears complete
// and safe from a power cut, or not at all; until then the copy lies beside it, in
// `target`.partial-XXXXXX, which only the death of the process leaves behind.
//
// NotFound where there is no map, AlreadyExists when there is a `target`, Cancelled when `progress`
// gave up, FailedPrecondition for what OpenSqliteStore refuses, io::FileError's where the copy
// cannot be written.
absl::StatusOr<StoreReport> BackUp(const std::string& directory, const std::string& target,
                                   const BackupProgress& progress = {});

}  // namespace isthmus::storage
