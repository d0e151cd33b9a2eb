// One turn of a spinning LiDAR, or one frame of another, as the odometry sees it.
#pragma once

#include <cstdint>
#include <vector>

namespace isthmus {

struct ScanPoint {
  float x = 0, y = 0, z = 0;  // Metres, sensor frame at the instant the point was measured.
  float intensity = 0;        // As the sensor gives it; no unit.
  // Seconds relative to the END of the scan, so <= 0. 0 if unknown, and where the position is that
  // of the END already.
  float time = 0;
  uint16_t ring = 0;  // Laser index, 0 = lowest elevation. 0 if unknown.
};

// Points in the order the sensor gave them. No-returns (NaN or zero range) have been dropped.
struct Scan {
  uint64_t sequence = 0;     // Per session, chosen by the robot, increasing.
  int64_t end_stamp_ns = 0;  // Nanoseconds since the Unix epoch, END of the turn or frame.
  bool has_ring = false;     // ScanPoint::ring is the sensor's own.
  // ScanPoint::time is the sensor's own. All 0: the scan is motion-compensated already.
  bool has_time = false;
  std::vector<ScanPoint> points;
};

}  // namespace isthmus
