#include "floam/track/start.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/geometry/near.h"
#include "floam/map/limits.h"
#include "floam/map/pole_search.h"
#include "floam/match/limits.h"
#include "floam/track/limits.h"

namespace isthmus::floam {
namespace {

Matrix6d AnyMotion() { return Isotropic(kAnyMotionM, kAnyMotionRad); }

}  // namespace

void Start::TakeFirstScan(const ScanFrame& frame, Tracker* tracker) {
  KeepFirstScan(frame, Pose(), tracker);
}

void Start::BeginAnew(const ScanFrame& frame, Tracker* tracker) {
  KeepFirstScan(frame, tracker->Prediction(frame).At(0), tracker);
}

void Start::KeepFirstScan(const ScanFrame& frame, const Pose& T_odom_end, Tracker* tracker) {
  first_ = frame.features;
  period_s_ = frame.period_s;
  stamp_ns_ = frame.stamp_ns;
  T_odom_first_ = T_odom_end;
  attempts_ = 0;
  tracker->BeginAt({{T_odom_end, Vector6d::Zero(), tracker->ReferenceTime(frame)}, stamp_ns_});
}

std::vector<ScanToScanResult> Start::MotionsBetween(const ScanFrame& frame, double elapsed_s) {
  std::vector<ScanToScanResult> motions;
  const auto try_from = [&](const Vector6d& twist) {
    ScanToScanResult moved = scan_to_scan_.Match(frame.features, twist, elapsed_s, AnyMotion());
    for (int again = 0; again < kMotionRepeats; ++again) {
      moved = scan_to_scan_.Match(frame.features, moved.twist, elapsed_s, AnyMotion());
    }
    const auto same = [&](const ScanToScanResult& other) {
      return AreNear(Exp(elapsed_s * moved.twist), Exp(elapsed_s * other.twist), kSameMotionM,
                     kSameMotionRad);
    };
    if (std::none_of(motions.begin(), motions.end(), same)) motions.push_back(moved);
  };
  try_from(Vector6d::Zero());
  for (const Pose& moved : MotionsOfPoles(first_.poles, frame.features.poles, elapsed_s)) {
    try_from(Log(moved) / elapsed_s);
  }
  std::sort(motions.begin(), motions.end(),
            [](const auto& a, const auto& b) { return a.evidence > b.evidence; });
  if (motions.size() > kMostMotions) motions.resize(kMostMotions);
  return motions;
}

Start::Beginning Start::MatchFrom(const ScanToScanResult& moved, const ScanFrame& frame,
                                  Tracker* tracker, FeatureMap* map) {
  MatchOptions matching = tracker->options().matching;
  matching.kernel_start_m = kRoughKernelM;
  const double elapsed_s = 1e-9 * static_cast<double>(frame.stamp_ns - stamp_ns_);
  const bool joined = moved.used >= tracker->options().min_used;
  Beginning began;
  ScanPose& first = began.first;
  first = tracker->last().pose;
  first.twist = moved.twist;
  for (int iteration = 0; iteration < kStartIterations; ++iteration) {
    first.T_odom_sensor = T_odom_first_ * Exp(first.reference_s * first.twist);
    map->Clear();
    map->Insert(first_, first, period_s_);
    frame.features.work.Add(Work::Kind::kMap, first_.map_surfaces.size() + first_.edges.size());
    if (frame.features.work.spent()) break;
    ScanPose guess = Predict(first, elapsed_s, tracker->ReferenceTime(frame));
    PosePrior prior = Near(guess.T_odom_sensor);
    const double between_s = elapsed_s + guess.reference_s - first.reference_s;
    if (joined) {
      guess.T_odom_sensor = first.T_odom_sensor * Exp(between_s * moved.twist);
      prior = {guess.T_odom_sensor, moved.covariance};
    }
    began.second = tracker->matcher()->Match(frame.features, guess, prior, std::nullopt, matching,
                                             map->surfaces(), map->edges(), map->poles());
    began.score = began.second.Score();
    if (joined) JoinMotion(moved, tracker->options(), *map, &began.second);
    if (!tracker->Fits(began.second, *map)) break;
    first.twist = Log(first.T_odom_sensor.Inverse() * began.second.pose.T_odom_sensor) / between_s;
    began.second.pose.twist = first.twist;
    // Two scans say little of height; a small error there must not add up.
    first.twist[2] = 0;
  }
  began.score += moved.evidence;
  return began;
}

MatchResult Start::TrackSecondScan(const ScanFrame& frame, Tracker* tracker, FeatureMap* map) {
  ++attempts_;
  const double elapsed_s = tracker->ElapsedSeconds(frame);
  Beginning best = MatchFrom(ScanToScanResult(), frame, tracker, map);
  scan_to_scan_.SetPrevious(first_);
  best.score += scan_to_scan_.Evidence(frame.features, best.first.twist, elapsed_s);
  for (const ScanToScanResult& moved : MotionsBetween(frame, elapsed_s)) {
    Beginning began = MatchFrom(moved, frame, tracker, map);
    if (began.score > best.score) best = std::move(began);
  }
  map->Clear();
  map->Insert(first_, best.first, period_s_);
  tracker->BeginAt({best.first, stamp_ns_});
  return best.second;
}

}  // namespace isthmus::floam
