// A scan made ready for matching.
#pragma once

#include <absl/status/status.h>

#include <cstdint>

#include "core/scan.h"
#include "floam/rings/ring_scan.h"
#include "floam/rings/sensor_model.h"
#include "floam/scan/features.h"

namespace isthmus::floam {

// A scan as the odometry works on it: in rings, with its features and its time. All times are 0 if
// it came motion-compensated.
struct ScanFrame {
  uint64_t sequence = 0;
  int64_t stamp_ns = 0;  // END of the scan.
  double period_s = 0;   // Duration of the turn, from the stamps where they tell.
  RingScan scan;
  Features features;

  // The middle of the instants at which points were measured, in seconds relative to the END.
  double MiddleS() const { return scan.is_compensated ? 0 : -0.5 * period_s; }
};

// Not thread safe: holds scratch memory.
class FrameMaker {
 public:
  FrameMaker(const SensorModel& sensor, const FeatureOptions& options);

  // Replaces `*frame`, whose memory is reused. `previous_ns` is the stamp of the scan before it, or
  // null for the first. InvalidArgument, `*frame` unspecified, as RingSorter::Sort or for time that
  // does not go forward.
  absl::Status Make(const Scan& input, const int64_t* previous_ns, ScanFrame* frame);

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.sorter_, self.extractor_);
  }

 private:
  const SensorModel sensor_;
  RingSorter sorter_;
  FeatureExtractor extractor_;
};

}  // namespace isthmus::floam
