// The store on disk: one SQLite database in WAL mode.
#pragma once

#include <absl/status/statusor.h>

#include <functional>
#include <memory>
#include <string>

#include "storage/map_store.h"

namespace isthmus::storage {

struct SqliteOptions {
  // Wait for the disk on every commit (synchronous=FULL). Off: a power cut may lose the last
  // commits, never the file's integrity.
  bool sync_every_commit = true;
  // Step to which submap coordinates are rounded, metres.
  double resolution_m = 0.001;
  // Told on opening what a person should know of the folder.
  std::function<void(const std::string& problem)> on_problem = nullptr;
};

// Opens, or creates, `directory`/isthmus.db and migrates it to the newest schema.
// FailedPrecondition when the database is newer than this program or another process holds it; the
// message says which.
absl::StatusOr<std::unique_ptr<MapStore>> OpenSqliteStore(const std::string& directory,
                                                          const SqliteOptions& options = {});

}  // namespace isthmus::storage
