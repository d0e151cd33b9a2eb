#include "floam/scan/scan_frame.h"

#include <absl/strings/str_cat.h>

#include <cmath>

#include "floam/rings/limits.h"

namespace isthmus::floam {
namespace {

// The order of points is known by now, and no motion is to be taken out of them.
void ForgetTimes(ScanFrame* frame) {
  for (RingPoint& p : frame->scan.points) p.time = 0;
  Features& features = frame->features;
  for (auto* points :
       {&features.edges, &features.surfaces, &features.map_surfaces, &features.poles}) {
    for (TimedPoint& p : *points) p.time = 0;
  }
}

}  // namespace

FrameMaker::FrameMaker(const SensorModel& sensor, const FeatureOptions& options)
    : sensor_(sensor), extractor_(options) {}

absl::Status FrameMaker::Make(const Scan& input, const int64_t* previous_ns, ScanFrame* frame) {
  frame->period_s = sensor_.scan_period_s;
  if (previous_ns != nullptr) {
    if (input.end_stamp_ns <= *previous_ns) {
      return absl::InvalidArgumentError(
          absl::StrCat("scan ", input.sequence, " ends at ", input.end_stamp_ns,
                       " ns, not after the scan before it (", *previous_ns,
                       " ns); scans must come in order of time"));
    }
    // The time between stamps is the better period, unless scans were dropped.
    const double between_s = 1e-9 * static_cast<double>(input.end_stamp_ns - *previous_ns);
    if (std::abs(between_s - frame->period_s) < kUnlikePeriod * frame->period_s) {
      frame->period_s = between_s;
    }
  }
  frame->sequence = input.sequence;
  frame->stamp_ns = input.end_stamp_ns;
  if (absl::Status status = sorter_.Sort(input, sensor_, frame->period_s, &frame->scan);
      !status.ok()) {
    return status;
  }
  frame->period_s = frame->scan.period_s;
  extractor_.Extract(frame->scan, &frame->features);
  if (frame->scan.is_compensated) ForgetTimes(frame);
  return absl::OkStatus();
}

}  // namespace isthmus::floam
