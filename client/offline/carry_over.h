// The parts of an old map that a rebuilt one takes over.
#pragma once

#include <absl/status/status.h>

#include <string>
#include <vector>

#include "client/offline/rebuild_map.h"
#include "core/ids.h"
#include "server/pipeline.h"
#include "storage/map_store.h"

namespace isthmus::cli {

// Submaps and poses of a session that `made` knows already.
absl::Status CopySession(const SessionId& session, const storage::MapStore& old,
                         storage::MapStore& made);

// Takes over manual decisions on pairs whose sessions are both in `made`: odom frames are the same,
// so all of a manual decision holds.
absl::Status CarryManualDecisions(const storage::MapStore& old, storage::MapStore& made,
                                  RebuildSummary& summary);

// Takes over the manual decisions that CarryManualDecisions could not, as segments are only there
// once they are made: those of which both old and new begin with the same scan, so that their odom
// frames are the same. The others are noted.
absl::Status CarrySegmentManualDecisions(const storage::MapStore& old, storage::MapStore& made,
                                         RebuildSummary& summary);

// To the submap of the same session that begins nearest in time, moved by how far that lies from
// the old one; of a later segment as above. Loop closures that were rejected by hand are not
// carried over, as others are found; a note says so. With the datum.
absl::Status CarryAnchors(const storage::MapStore& old, const std::vector<SessionId>& sessions,
                          server::Pipeline& pipeline, RebuildSummary& summary);

// The archive of a session: segments that will not change are shared by hard links where the file
// system can, the last one is copied.
absl::Status CopyScans(const std::string& from, const std::string& to, const SessionId& session);

}  // namespace isthmus::cli
