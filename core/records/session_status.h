// A session as it is reported.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/map/session.h"
#include "core/point_payload.h"
#include "core/pose.h"
#include "core/tracking.h"

namespace isthmus {

struct SessionStatus {
  SessionRecord record;
  // For a session that a robot opened, all but the submaps, points and the placement are of all its
  // segments; for a later segment they are its own or empty.
  uint64_t last_sequence = 0;     // Highest scan that took effect.
  uint64_t durable_sequence = 0;  // Scans up to here survive a crash of the server.
  uint64_t scans_processed = 0;   // Since the server started.
  uint64_t scans_rejected = 0;
  uint32_t submap_count = 0;
  uint64_t point_count = 0;
  double odometry_ms_mean = 0;  // Per scan, decoding apart.
  double travelled_m = 0;       // After a restart without what retired submaps lay along.
  Tracking tracking = Tracking::kUnknown;  // As of the newest scan.
  std::string input;  // Origin of its scans' rings and times; empty before the first.
  std::optional<uint32_t> component;  // Absent until the session has been placed.
  std::optional<Pose> T_map_odom;     // Absent until then, too. At its newest submap.
  uint64_t map_bytes = 0;             // Stored of its submaps and features, as counted last.
  uint64_t scan_bytes = 0;            // Bytes of its raw scans.
  uint64_t quota_bytes = 0;           // Limit for all sessions of its robot; 0: no limit.
  // The raw scans that are missing, and why; empty while all are kept, or none are to be.
  std::string archive_problem = {};
  uint32_t segments = 1;  // Number of segments so far.
  ScanCounts scans = {};  // From the first scan on.
  // The newest version of quantised data that the server reads; 0: it knows version 1 alone.
  uint32_t quantized_version = kQuantizedVersion;
  int64_t lost_since_ns = 0;  // END of the first scan since it was tracked last; 0: it is.
};

}  // namespace isthmus
