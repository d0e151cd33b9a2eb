// The check of a map folder: reads all of it and lists the damage.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

namespace isthmus::storage {

struct DamagedRecord {
  std::string record;  // As "submap alice-1/3" or "the database".
  std::string problem;
};

struct StoreReport {
  int64_t schema = 0;
  int64_t sessions = 0, submaps = 0, scans = 0, features = 0, matches = 0, loops = 0, revisions = 0;
  int64_t checkpoints = 0;
  int64_t events = 0;
  int64_t points = 0;  // Points of the submaps that are whole.
  // The first kDamagedListed of damaged_count.
  std::vector<DamagedRecord> damaged;
  int64_t damaged_count = 0;
};

inline constexpr size_t kDamagedListed = 1000;

// Reads `directory`/isthmus.db from end to end: SQLite's own checks of the file, its index of
// places and the references between records; of every record, the checksum and decoding of its
// blobs, its counts and its poses. Bits flipped in other columns show only where SQLite or these
// see them: there is no checksum over rows. A write-ahead log that is missing
// shows as commits that are not there, unless the rest does not fit together; one that is damaged
// is told from one that a power cut left.
//
// Writes to none of the files (SQLite may make isthmus.db-shm). Folders of older schemas are read
// as they are, but for the points of submaps before schema 5. Holds the folder's lock meanwhile, if
// there is one: FailedPrecondition while a server runs, and for what OpenSqliteStore refuses;
// NotFound where there is no map.
absl::StatusOr<StoreReport> CheckStore(const std::string& directory);

// A few lines for people, ending with a newline.
std::string ToString(const StoreReport& report);

}  // namespace isthmus::storage
