// The scans of one sensor out of a recording, one after the other.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/point_payload.h"
#include "core/pose.h"

namespace isthmus::readers {

struct RecordedScan {
  int64_t end_stamp_ns = 0;  // END of the scan, nanoseconds since the Unix epoch.
  // x y z in metres (sensor frame at the instant of each measurement), and other fields if there
  // are any: intensity, ring, time.
  PointPayload payload;
  std::string name;  // Its name in messages: "scans/000012.pcd", "scan 12 of /points".
  // T_frame_sensor, as the file itself tells it, in a frame of the files' own; of PCDs only.
  std::optional<Pose> viewpoint = std::nullopt;
  std::string frame = {};  // The points' frame, as a message's header names it; else empty.
};

// Reads as it is asked, and holds no more than a scan or two. Not thread safe, but for Interrupt.
class ScanReader {
 public:
  virtual ~ScanReader() = default;

  // The next scan; empty after the last one. An error is that of one scan, or of a stretch of the
  // recording that is damaged, and names it: the next call goes on behind it. Every recording ends,
  // however damaged; a live sensor does when it is interrupted.
  virtual absl::StatusOr<std::optional<RecordedScan>> Next() = 0;

  // Number of scans, if it is known beforehand.
  virtual std::optional<uint64_t> size() const { return std::nullopt; }

  // The name of the sensor (sensor_model.h), as far as the scans so far tell; else empty.
  virtual std::string sensor() const { return {}; }

  // False where nothing but a clock of their points stamps the scans: stamps may only count them.
  virtual bool has_stamps() const { return true; }

  // Assumptions in place of facts that the recording lacks, each in a sentence without a full stop:
  // "stamps are taken for the END of scans: points have no times". Later scans may add some.
  virtual std::vector<std::string> Assumptions() const { return {}; }

  // Thread safe: a Next that waits for a live sensor, and every later one, returns empty.
  virtual void Interrupt() {}
};

}  // namespace isthmus::readers
