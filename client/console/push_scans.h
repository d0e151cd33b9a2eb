// The loop that pushes a folder of scans into a session, shared by `push` and `odometry`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/library/client.h"
#include "client/readers/folder/scan_folder.h"
#include "core/odometry_mode.h"

namespace isthmus::cli {

struct PushOptions {
  std::string robot;
  std::string sensor;
  std::optional<OdometryMode> odometry = {};     // Absent: the server's own choice.
  std::optional<double> pace_hz = std::nullopt;  // Absent: as fast as the server takes them.
  double resolution_m = 0;                       // Quantisation; 0: raw.
  bool finish = true;                            // Finish the session afterwards.
  // Folder of a spool: an earlier push that was cut off is gone on with. Empty: none.
  std::string spool = {};
};

struct PushSummary {
  SessionId session;
  client::ScanStreamStats scans;
  uint64_t unreadable = 0;  // Files that could not be read; each was named on stderr.
  uint64_t before = 0;      // Scans that an earlier push with this spool had taken.
  double seconds = 0;       // Wall time.
  double mean_ms = 0;       // Computing time of the odometry per processed scan.
  SessionStatus state;      // Of the session, at the end.
  std::vector<ScanAck> acks;
  std::string first_rejection;  // Its reason.
};

// Opens a session and pushes every scan; with a spool it goes on behind the last one that was
// taken. A scan that cannot be read or used is reported on stderr and left out; the others go on.
// So is, at once, the beginning of a segment.
absl::StatusOr<PushSummary> PushFolder(client::Client& client, const readers::ScanFolder& folder,
                                       const PushOptions& options);

}  // namespace isthmus::cli
