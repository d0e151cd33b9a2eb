#include "floam/start.h"

#include <optional>

namespace isthmus::floam {
namespace {

constexpr int kIterations = 4;
constexpr double kKernelM = 1.0;

}  // namespace

void Start::First(const ScanFrame& frame, Tracker* tracker) {
  first_ = frame.features;
  period_s_ = frame.period_s;
  stamp_ns_ = frame.stamp_ns;
  tracker->Begin({{Pose(), Vector6d::Zero(), tracker->ReferenceTime(frame)}, stamp_ns_});
}

MatchResult Start::Second(const ScanFrame& frame, Tracker* tracker, FeatureMap* map) {
  MatchOptions matching = tracker->Matching(*map);
  matching.kernel_start_m = kKernelM;
  const double elapsed_s = tracker->ElapsedSeconds(frame);
  ScanPose first = tracker->last().pose;
  MatchResult match;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    first.T_odom_sensor = Exp(first.reference_s * first.twist);
    map->Clear();
    map->Insert(first_, first, period_s_);
    match = tracker->matcher()->Match(frame.features,
                                      Predict(first, elapsed_s, tracker->ReferenceTime(frame)),
                                      std::nullopt, matching, map->surfaces(), map->edges());
    if (!tracker->Fits(match, *map)) break;
    const double between_s = elapsed_s + match.pose.reference_s - first.reference_s;
    first.twist = Log(first.T_odom_sensor.Inverse() * match.pose.T_odom_sensor) / between_s;
    match.pose.twist = first.twist;
  }
  tracker->Begin({first, stamp_ns_});
  return match;
}

}  // namespace isthmus::floam
