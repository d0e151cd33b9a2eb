// State of a session that its next scan depends on, with its saving and restoring.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/codec/scan_decoder.h"
#include "core/map/session.h"
#include "core/map/trajectory.h"
#include "core/scan_clock.h"
#include "floam/odometry.h"
#include "floam/odometry_options.h"
#include "floam/submap_builder.h"

namespace isthmus::ingest {

// Not thread safe.
struct OdometryCheckpointState {
  // In a segment whose submaps are numbered from `first_index`.
  OdometryCheckpointState(const SessionRecord& record, const floam::SensorModel& sensor,
                          const floam::OdometryOptions& odometry_options,
                          const floam::SubmapOptions& submap_options, uint32_t in_segment,
                          uint32_t first_index);

  // Goes on in the next segment. The unfinished submap of this one is gone: finish it first.
  void BeginSegment();

  // Exactly, and compressed; without what the odometry was told to remember.
  absl::StatusOr<std::string> Save() const;
  // Call on a new object. `remember`, called once, tells the odometry what the saved one's
  // remembered: the submaps of `segment`, which is known by then. InvalidArgument for a state of
  // another version or other settings, DataLoss for a damaged one; not to be used any more then.
  absl::Status Restore(const std::string& saved, const std::function<void()>& remember);

  codec::ScanDecoder decoder;
  ScanClock clock;
  floam::Odometry odometry;
  uint32_t segment;                             // Its number in the session.
  uint32_t odometry_segment = 1;                // The odometry's own count, which a resumed session
                                                // without a checkpoint begins anew.
  std::optional<floam::SubmapBuilder> builder;  // The segment's builder; always there.
  std::vector<TrajectoryEntry> unfinished;      // Scans of the unfinished submap.
  int blind_scans = 0;                          // In a row, up to the last.
  ScanCounts counts;                            // From the session's first scan on.
  int64_t lost_since_ns = 0;  // END of the first scan since it was tracked last; 0: it is.
  uint32_t lost_scans = 0;    // Since then.

 private:
  void MakeBuilder(uint32_t first_index);

  const SessionId session_;
  const RobotId robot_;
  const floam::SubmapOptions submap_options_;
};

}  // namespace isthmus::ingest
