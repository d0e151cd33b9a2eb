// A summary in words of how well a robot's scans could be tracked.
#pragma once

#include <string>
#include <vector>

#include "client/library/client.h"

namespace isthmus::cli {

// "180 ok, 2 degenerate, 15 lost, 3 rejected".
std::string CountsText(const ScanCounts& scans);

// "; segment 2 of 2; LOST since stamp 1700000012.300", of which what does not apply is left out.
std::string SegmentAndLossText(const SessionStatus& session);

// The lost part of a drive: scans that could not be matched, or not be used at all.
struct Loss {
  uint64_t lost = 0, scans = 0;
  uint32_t segments = 1;

  // More than a tenth of the scans, or poses that share no frame.
  bool IsMuch() const { return lost * 10 > scans || segments > 1; }
};
Loss LossOf(const std::vector<ScanAck>& acks, uint32_t segments);

// "in 150 of 200 scans (75 %) a direction was not observed; along it the poses are extrapolated";
// empty when half the scans or fewer are degenerate.
std::string DegeneracyText(const ScanCounts& scans);

// "lost in 117 of 200 scans (58 %), 3 segments; poses of different segments share no frame".
std::string ToString(const Loss& loss);

}  // namespace isthmus::cli
