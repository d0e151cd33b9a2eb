// The revisions of a map: where its submaps lie as of the latest, and how they came there.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "core/map/revision.h"

namespace isthmus::storage {

// A summary of a revision's moves.
RevisionInfo Describe(const MapRevision& revision, const std::vector<SubmapMove>& moves);

// OutOfRange or NotFound where the changes after `from` up to `to` are not known: `oldest` is the
// oldest revision that the log can be asked about, `latest` the newest.
absl::Status CheckRange(int64_t from, int64_t to, int64_t oldest, int64_t latest);

// MapStore's promises about revisions, kept in memory. Not thread safe.
class RevisionLog {
 public:
  // The revision and its moves have passed CheckBatch.
  void Add(const MapRevision& revision, std::vector<SubmapMove> moves);

  int64_t latest() const { return latest_.revision; }
  MapRevision Latest() const;
  std::vector<RevisionInfo> List(int limit) const;
  absl::StatusOr<std::vector<std::pair<int64_t, SubmapMove>>> Moves(int64_t from, int64_t to) const;

 private:
  struct Entry {
    RevisionInfo info;
    std::vector<SubmapMove> moves;  // In order of submap.
  };
  void Prune();

  MapRevision latest_;                                    // Its placements without their submaps.
  std::map<SessionId, std::map<uint32_t, Pose>> placed_;  // T_map_submap as of the latest.
  std::map<int64_t, Entry> entries_;                      // By revision.
  int64_t move_count_ = 0;                                // In all entries.
};

}  // namespace isthmus::storage
