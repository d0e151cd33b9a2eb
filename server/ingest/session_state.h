// All of a session that its next scan depends on, and how it outlives the server.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/codec/scan_decoder.h"
#include "core/session.h"
#include "core/trajectory.h"
#include "floam/odometry.h"
#include "floam/odometry_options.h"
#include "floam/submap_builder.h"
#include "server/ingest/scan_clock.h"

namespace isthmus::ingest {

// Not thread safe.
struct SessionState {
  // Submaps are numbered from `first_index`.
  SessionState(const SessionRecord& record, const floam::SensorModel& sensor,
               const floam::OdometryOptions& odometry_options,
               const floam::SubmapOptions& submap_options, uint32_t first_index);

  // Exactly, and compressed; without what the odometry was told to remember.
  absl::StatusOr<std::string> Save() const;
  // Of a new one, once the odometry remembers what the saved one's did. InvalidArgument for what
  // another version or other settings made, DataLoss for what is damaged; not to be used any more
  // then.
  absl::Status Restore(const std::string& saved);

  codec::ScanDecoder decoder;
  ScanClock clock;
  floam::Odometry odometry;
  floam::SubmapBuilder builder;
  std::vector<TrajectoryEntry> stretch;  // Scans of the unfinished submap.
  int blind_scans = 0;                   // In a row, up to the last.
};

}  // namespace isthmus::ingest
