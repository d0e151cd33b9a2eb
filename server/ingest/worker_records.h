// Records that a session's worker is given and returns, and its hooks.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/map/finished_submap.h"
#include "core/map/session.h"
#include "core/map/submap.h"
#include "core/map/trajectory.h"
#include "core/pose.h"
#include "core/records/event.h"
#include "core/tracking.h"

namespace isthmus::ingest {

// Callbacks of a worker into its surroundings. Called from executor threads, one call at a time per
// worker, without any lock of the worker's but that which serialises `persist`.
struct WorkerHooks {
  // Makes a submap durable and hands it on. On error it is kept and offered again.
  std::function<absl::Status(const FinishedSubmap&)> persist;
  // The segment's newest placement.
  std::function<std::optional<Pose>(uint32_t segment)> T_map_odom;
  // A scan has been dealt with (its ack was sent).
  std::function<void()> scan_done;
  // The session got lost, was found again, began a segment. May be null.
  std::function<void(Event)> tell = {};
};

// The durable part of one segment.
struct StoredSegment {
  uint32_t segment = 1;
  uint32_t next_index = 0;     // One more than that of the last submap.
  uint64_t last_sequence = 0;  // Last scan of the last submap.
  // Calls with every submap that can be read, one at a time, in order. May be null: there are none.
  std::function<void(const std::function<void(const Submap&)>&)> for_each_submap = {};
  std::vector<TrajectoryEntry> trajectory = {};  // All, in order.
};

// The point at which a session continues: its durable part.
struct ResumePoint {
  std::optional<SessionCheckpoint> checkpoint = {};
  std::vector<StoredSegment> segments = {};  // In order; none in a new session.
};

struct WorkerStatus {
  uint64_t last_sequence = 0;  // Highest that was dealt with.
  uint64_t durable_sequence = 0;
  uint64_t processed = 0;  // By this worker, as the next.
  uint64_t rejected = 0;
  ScanCounts scans;           // From the session's first scan on, if its checkpoints were usable.
  uint32_t segment = 1;       // The session's current segment.
  int64_t lost_since_ns = 0;  // END of the first scan since it was tracked last; 0: it is.
  double odometry_ms_mean = 0;
  double travelled_m = 0;
  Tracking tracking = Tracking::kUnknown;
  // A description of how rings and times of the scans were found, empty before the first; and
  // `resumed`.
  std::string input;
  // "resumed from submaps: ..." and why, where there was a checkpoint that could not be used.
  std::string resumed;
  // Scans whose submap is not stored yet, by segment.
  std::map<uint32_t, std::vector<TrajectoryEntry>> unsaved;
};

}  // namespace isthmus::ingest
