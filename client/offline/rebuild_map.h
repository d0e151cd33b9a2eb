// A map folder made anew from the scans that its archive holds.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/ids.h"
#include "server/pipeline_options.h"
#include "storage/sqlite/sqlite_store.h"

namespace isthmus::cli {

struct RebuildOptions {
  std::string from, to;              // Map folders; `to` does not exist yet, or is empty.
  std::vector<SessionId> sessions;   // Empty: all.
  server::PipelineOptions pipeline;  // Archive and retention are not looked at.
  storage::SqliteOptions storage;
  bool with_scans = false;  // The new folder gets the archive of its sessions, too.
};

struct RebuiltSession {
  SessionId id;
  bool is_copied = false;  // No scans are archived: its submaps are as they were.
  uint64_t scans = 0;      // In the archive.
  uint64_t processed = 0;  // Scans of the archive; the others were rejected.
  uint64_t missing = 0;    // Holes in the archive, damaged scans among them.
  uint32_t submaps = 0;    // Submaps of the new map, in so many segments.
  uint32_t segments = 0;
  uint64_t compared = 0;  // Scans that have a pose in both maps.
  double rmse_m = 0;      // Between their positions in odom, old and new.
  double max_m = 0;
};

struct RebuildSummary {
  std::vector<RebuiltSession> sessions;        // In order of creation.
  uint64_t manual_decisions = 0, anchors = 0;  // Carried over.
  std::vector<std::string> notes;              // Parts not carried over, and damage.
};

// Told how many of how many scans were read.
using RebuildProgress = std::function<void(uint64_t done, uint64_t total)>;

// A session is made anew with its segments, which may begin elsewhere with other parameters.
//
// Reads `from`, which no server may use meanwhile, and changes nothing in it (but that a store of
// an older version is brought up to date). Sessions keep their ids and are all finished.
// A scan that is missing is as one that could not be used. With the parameters of before, and a
// full archive without holes, poses come out as they were, bit by bit.
//
// What a person said of pairs holds on; anchors go to the new submap that begins nearest in time to
// the old one. Of later segments only where the new one begins with the same scan: else its frame
// is another. NotFound for a folder without a map or an unknown session, FailedPrecondition when a
// server has the folder, AlreadyExists when `to` holds something.
absl::StatusOr<RebuildSummary> RebuildMap(const RebuildOptions& options,
                                          const RebuildProgress& progress);

}  // namespace isthmus::cli
