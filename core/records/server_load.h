// The load of a site: what waits in it, how far each robot's scans have come, what caches and the
// disk hold.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/ids.h"
#include "core/map/match.h"
#include "core/map/trajectory.h"
#include "core/records/replica_state.h"
#include "core/records/robot_place.h"
#include "core/tracking.h"

namespace isthmus {

// The load of a session that takes scans or uploads. Times are nanoseconds of the server's clock, 0
// if there is none to tell.
struct SessionLoad {
  SessionId session;  // As the robot opened it, all segments together.
  RobotId robot;
  uint64_t waiting_scans = 0;  // In its queue; the one at work is not.
  uint64_t waiting_bytes = 0;  // Encoded bytes of these scans.
  // Each up to and including; never more than the one before, but for a moment.
  uint64_t received_sequence = 0, acknowledged_sequence = 0, durable_sequence = 0;
  int64_t received_ns = 0;  // When the newest scan came; since the server started, as what follows.
  int64_t ack_delay_ns =
      0;  // From the coming of the newest acknowledged scan to its acknowledgement.
  // When the oldest scan came that is not acknowledged, or not durable, yet. 0 also where that was
  // before the server started.
  int64_t oldest_unacknowledged_ns = 0, oldest_undurable_ns = 0;
  uint64_t scans_processed = 0, scans_rejected = 0;  // Since the server started.
  uint64_t scans_skipped = 0;                        // Since the session began.
  Tracking tracking = Tracking::kUnknown;            // As of the newest scan.
  int64_t lost_since_ns =
      0;  // By the robot's clock: END of the first lost scan; 0: it is not lost.
  // T_odom_sensor of the newest scan that could be tracked, and whose segment's odom that is.
  std::optional<StampedPose> newest;
  uint32_t newest_segment = 1;
  uint64_t submaps = 0;     // Stored.
  uint64_t map_bytes = 0;   // Stored of them and their features, as counted last.
  uint64_t scan_bytes = 0;  // Bytes of its raw scans.
};

// In memory.
struct CacheLoad {
  uint64_t bytes = 0, limit_bytes = 0;
};

struct MatchingLoad {
  bool is_idle = true;  // It has dealt with all that the map shows. Else it is at work.
  // As of when it began with what it is at; that included. Submaps that wait for loop closures, and
  // pairs with new evidence; where there are too many sessions to try all pairs, those never tried
  // count as one.
  uint64_t submaps = 0, pairs = 0;
  // Processes that do jobs for it, as of seconds ago, jobs that they have or are to take, and those
  // that workers or servers ended with time and again, left out.
  uint64_t workers = 0, jobs = 0, jobs_set_aside = 0;
};

// Zeros where nothing is kept on disk.
struct DiskLoad {
  uint64_t database_bytes = 0, log_bytes = 0;  // The database's file, and its write-ahead log.
  uint64_t scan_bytes = 0;                     // Raw scans of all sessions.
  uint64_t spilled_bytes = 0;                  // The composed map's file.
  uint64_t free_bytes = 0, total_bytes = 0;    // Space of the file system.

  // By the data folder, but for uploads under way.
  uint64_t used_bytes() const { return database_bytes + log_bytes + scan_bytes + spilled_bytes; }
};

// Pairs of sessions whose match is in that state, for that reason.
struct MatchCount {
  MatchState state = MatchState::kNotYet;
  MatchReason reason = MatchReason::kNone;
  uint64_t matches = 0;
};

struct ServerLoad {
  int64_t now_ns = 0;                  // The server's clock, when all this was so.
  std::vector<SessionLoad> sessions;   // Open ones, in order of their ids.
  std::vector<RobotPlace> localising;  // In order of their names, then of their beginnings.
  // Sums over all sessions; bytes include the scans at work.
  uint64_t waiting_scans = 0, waiting_bytes = 0, waiting_bytes_limit = 0;
  // Limits of one session.
  uint64_t session_scans_limit = 0, session_bytes_limit = 0;
  uint64_t submaps_coming_in = 0;  // Uploads that are being checked and stored.
  MatchingLoad matching;
  std::vector<MatchCount> matches;  // By state, then reason.
  bool placement_waits = false;     // Something has changed that the latest revision does not show.
  bool composition_waits = false;   // The composed map is not of the latest revision.
  bool map_is_loading = false;  // After a start: no map has been composed yet, none can be read.
  int64_t revision = 0;
  uint64_t submaps = 0;  // In the latest revision.
  // The last of each, wall time, and how many since the server started.
  double composition_ms = 0, placement_ms = 0, estimation_ms = 0;
  uint64_t compositions = 0, placements = 0, estimations = 0;
  CacheLoad submap_cache, prepared_maps;
  CacheLoad composed;  // Thinned submaps and tiles, as of the last composition.
  DiskLoad disk;
  std::string storage_problem;          // As in MapInfo.
  std::optional<ReplicaState> replica;  // As in MapInfo.
};

}  // namespace isthmus
