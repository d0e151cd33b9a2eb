// The cut between one turn of a sensor and the next.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "client/readers/packets/scan_builder.h"

namespace isthmus::readers {

// The assumption of decoders about several returns of a laser.
inline constexpr char kBothReturnsKept[] =
    "both returns become points, those of a firing's first block before those of the second; equal "
    "ones become one point";

// A scan ends where the azimuth (hundredths of a degree, that of the sensor) passes that of the
// cut, where packets are missing that may be a turn, and at the limits of limits.h. Not thread
// safe.
class TurnCutter {
 public:
  // `by_flush`: messages are whole turns; scans end at the limit of their points alone.
  TurnCutter(double cut_deg, bool by_flush);

  // Before the first block of a packet, at its time (nanoseconds): whether so much time passed
  // since the last packet that a whole turn may be lost.
  bool MissesATurn(int azimuth, int64_t time_ns);
  // Hundredths of a degree per nanosecond, from packet to packet; 0: not known yet.
  double speed() const { return speed_; }
  // Before a block of so many points: whether the scan so far ends.
  bool EndsBefore(int azimuth, int64_t time_ns, const ScanBuilder& scan, size_t points);
  // "scans begin where the sensor's azimuth passes 0 degrees"
  std::string Description() const;
  // Another scan begins.
  void Forget() { last_azimuth_.reset(); }

 private:
  const int cut_;
  const bool by_flush_;
  std::optional<int> last_azimuth_;  // Past the cut, of the last block.
  std::optional<int64_t> packet_ns_;
  int packet_azimuth_ = 0;
  double speed_ = 0;
};

}  // namespace isthmus::readers
