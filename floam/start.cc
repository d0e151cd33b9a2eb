#include "floam/start.h"

#include <optional>

namespace isthmus::floam {
namespace {

constexpr int kIterations = 4;
constexpr double kKernelM = 1.0;
constexpr int kBetweenRounds = 3;

double Score(const MatchResult& match) { return match.agreement * match.used; }

}  // namespace

void Start::First(const ScanFrame& frame, Tracker* tracker) { Keep(frame, Pose(), tracker); }

void Start::Again(const ScanFrame& frame, Tracker* tracker) {
  Keep(frame, tracker->Prediction(frame).At(0), tracker);
}

void Start::Keep(const ScanFrame& frame, const Pose& T_odom_end, Tracker* tracker) {
  first_ = frame.features;
  period_s_ = frame.period_s;
  stamp_ns_ = frame.stamp_ns;
  T_odom_first_ = T_odom_end;
  attempts_ = 0;
  tracker->Begin({{T_odom_end, Vector6d::Zero(), tracker->ReferenceTime(frame)}, stamp_ns_});
}

Vector6d Start::MotionBetween(const ScanFrame& frame, double elapsed_s) {
  scan_to_scan_.SetPrevious(first_);
  Vector6d twist = Vector6d::Zero();
  for (int round = 0; round < kBetweenRounds; ++round) {
    twist = scan_to_scan_.Match(frame.features, twist, elapsed_s).twist;
  }
  return twist;
}

MatchResult Start::MatchFrom(const Vector6d& twist, const ScanFrame& frame, Tracker* tracker,
                             FeatureMap* map, ScanPose* first) {
  MatchOptions matching = tracker->options().matching;
  matching.kernel_start_m = kKernelM;
  const double elapsed_s = 1e-9 * static_cast<double>(frame.stamp_ns - stamp_ns_);
  first->twist = twist;
  MatchResult match;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    first->T_odom_sensor = T_odom_first_ * Exp(first->reference_s * first->twist);
    map->Clear();
    map->Insert(first_, *first, period_s_);
    const ScanPose guess = Predict(*first, elapsed_s, tracker->ReferenceTime(frame));
    match =
        tracker->matcher()->Match(frame.features, guess, tracker->Near(guess.T_odom_sensor, *map),
                                  std::nullopt, matching, map->surfaces(), map->edges());
    if (!tracker->Fits(match, *map)) break;
    const double between_s = elapsed_s + match.pose.reference_s - first->reference_s;
    first->twist = Log(first->T_odom_sensor.Inverse() * match.pose.T_odom_sensor) / between_s;
    match.pose.twist = first->twist;
    // Two scans say little of height; a small error there must not add up.
    first->twist[2] = 0;
  }
  return match;
}

MatchResult Start::Second(const ScanFrame& frame, Tracker* tracker, FeatureMap* map) {
  ++attempts_;
  const double elapsed_s = tracker->ElapsedSeconds(frame);
  ScanPose first = tracker->last().pose;
  const MatchResult from_rest = MatchFrom(Vector6d::Zero(), frame, tracker, map, &first);
  ScanPose moving = first;
  MatchResult match = MatchFrom(MotionBetween(frame, elapsed_s), frame, tracker, map, &moving);
  if (Score(match) > Score(from_rest)) {
    first = moving;
  } else {
    match = from_rest;
    map->Clear();
    map->Insert(first_, first, period_s_);
  }
  tracker->Begin({first, stamp_ns_});
  return match;
}

}  // namespace isthmus::floam
