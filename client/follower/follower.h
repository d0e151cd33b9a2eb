// A robot that is followed where this program runs: scans in, submaps to upload out.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/odometry_mode.h"
#include "core/point_payload.h"
#include "core/pose.h"
#include "core/records/submap_upload.h"
#include "core/scan_upload.h"

namespace isthmus::follower {

struct FollowerOptions {
  std::string sensor;  // Name of a sensor model.
  Pose T_base_sensor;
  std::optional<OdometryMode> odometry;  // Absent: the usual one.
  double resolution_m = 0.002;           // Coordinates of submaps are rounded so; 0: every bit.
};

// A submap, and which segment of the drive it is of: a session of its own.
struct FollowedSubmap {
  uint32_t segment = 1;
  SubmapUpload upload;  // Its session is empty, indices count from 0 in each segment.
};

// The outcome of a scan.
struct FollowedScan {
  ScanAck ack;  // As of a server, without the facts that only it knows: session, place, durability.
  std::vector<FollowedSubmap> submaps;  // Completed by the scan, in order.
};

// The server's work on streamed scans, with the same odometry and the same submaps: thinned
// keyframes. The same scans give the same submaps, bit by bit. Not thread safe.
class Follower {
 public:
  // NotFound for an unknown sensor, with the known ones in the message.
  static absl::StatusOr<std::unique_ptr<Follower>> Create(const FollowerOptions& options);
  ~Follower();

  // In order of time. A scan that cannot be used is rejected in its ack. Errors are those of
  // packing a submap.
  absl::StatusOr<FollowedScan> Take(const PointPayload& payload, uint64_t sequence,
                                    int64_t end_stamp_ns);
  // The unfinished submaps.
  absl::StatusOr<std::vector<FollowedSubmap>> Finish();

  const ScanCounts& counts() const;
  uint32_t segment() const;

 private:
  struct State;
  explicit Follower(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isthmus::follower
