#include "floam/track/tracker.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "floam/track/limits.h"

namespace isthmus::floam {
void JoinMotion(const ScanToScanResult& moved, const OdometryOptions& options,
                const FeatureMap& map, MatchResult* match) {
  match->information += moved.information;
  match->degeneracy = FindDegeneracy(match->information, FreeMotion(options.matching));
  if (map.IsYoung()) match->map_degeneracy = match->degeneracy;
  match->seconded = moved.used >= options.min_used_share * moved.features &&
                    moved.score >= options.min_agreement * moved.used;
}

ScanPose Predict(const ScanPose& last, double elapsed_s, double reference_s) {
  const double time_s = std::min(elapsed_s, kMaxExtrapolationS) + reference_s;
  ScanPose moving = last;
  if (elapsed_s > kMaxTiltingS) moving.twist.segment<2>(3) *= kMaxTiltingS / elapsed_s;
  return {moving.At(time_s), last.twist, reference_s};
}

Tracker::Tracker(const SensorModel& sensor, const OdometryOptions& options)
    : sensor_(sensor), options_(options) {}

double Tracker::ElapsedSeconds(const ScanFrame& frame) const {
  return 1e-9 * static_cast<double>(frame.stamp_ns - last_.stamp_ns);
}

double Tracker::ReferenceTime(const ScanFrame& frame) const {
  return IsContinuous() ? frame.MiddleS() : 0;
}

double Tracker::SecondsBetween(const ScanFrame& frame) const {
  return ElapsedSeconds(frame) + ReferenceTime(frame) - last_.pose.reference_s;
}

bool Tracker::IsAfterGap(const ScanFrame& frame) const {
  return ElapsedSeconds(frame) > kGapPeriods * sensor_.scan_period_s;
}

ScanPose Tracker::Prediction(const ScanFrame& frame) const {
  return Predict(last_.pose, ElapsedSeconds(frame), ReferenceTime(frame));
}

std::optional<TwistPrior> Tracker::Prior(const ScanFrame& frame) const {
  if (!IsContinuous()) return std::nullopt;
  TwistPrior prior;
  prior.T_odom_previous = last_.pose.T_odom_sensor;
  prior.since_previous_s = SecondsBetween(frame);
  if (IsAfterGap(frame)) {
    prior.sigma = MotionModel::TwistChange(SecondsBetween(frame));
    return prior;
  }
  prior.sigma.head<3>().setConstant(options_.speed_change_sigma);
  prior.sigma.segment<2>(3).setConstant(options_.tilt_rate_sigma);
  prior.sigma[5] = options_.yaw_rate_change_sigma;
  return prior;
}

PosePrior Near(const Pose& T_odom_sensor) { return {T_odom_sensor, Isotropic(kNearM, kNearRad)}; }

std::optional<ScanToScanResult> Tracker::LookBack(const ScanFrame& frame, PosePrior* prior) {
  if (!keeps_last_) return std::nullopt;
  const Pose& T_odom_last = last_.pose.T_odom_sensor;
  const Vector6d expected =
      Log(T_odom_last.Inverse() * prior->T_odom_sensor) / SecondsBetween(frame);
  ScanToScanResult moved =
      scan_to_scan_.Match(frame.features, expected, ElapsedSeconds(frame), prior->covariance);
  if (moved.used < options_.min_used) return std::nullopt;
  *prior = {T_odom_last * Exp(SecondsBetween(frame) * moved.twist), moved.covariance};
  return moved;
}

bool Tracker::IsSteady(const ScanFrame& frame) const {
  // Clocks may step back.
  return frame.stamp_ns < steady_until_ns_ && frame.stamp_ns >= steady_until_ns_ - kSteadyNs;
}

MatchResult Tracker::Match(const ScanFrame& frame, const ScanPose& guess, FeatureMap* map) {
  return Match(frame, guess, needs_last_, map);
}

MatchResult Tracker::MatchToLast(const ScanFrame& frame, const ScanPose& guess, FeatureMap* map) {
  return Match(frame, guess, true, map);
}

MatchResult Tracker::Match(const ScanFrame& frame, const ScanPose& guess, bool to_last,
                           FeatureMap* map) {
  if (IsSteady(frame) && !map->IsYoung())
    motion_.ExpectAcceleration(acceleration_);
  else
    motion_.ExpectAnything();
  PosePrior prior{guess.T_odom_sensor, motion_.Displacement(SecondsBetween(frame))};
  ScanPose from = guess;
  std::optional<ScanToScanResult> moved;
  if (to_last) moved = LookBack(frame, &prior);
  if (moved) from.T_odom_sensor = prior.T_odom_sensor;
  MatchResult match = matcher_.Match(frame.features, from, prior, Prior(frame), options_.matching,
                                     map->surfaces(), map->edges(), map->poles());
  if (moved) JoinMotion(*moved, options_, *map, &match);
  return match;
}

MatchResult Tracker::MatchNear(const ScanFrame& frame, const ScanPose& guess,
                               const MatchOptions& options, FeatureMap* map) {
  return matcher_.Match(frame.features, guess, Near(guess.T_odom_sensor), Prior(frame), options,
                        map->surfaces(), map->edges(), map->poles());
}

void Tracker::BeginAt(const Sighting& sighting) {
  last_ = sighting;
  motion_ = MotionModel();
  keeps_last_ = false;
}

bool Tracker::Fits(const MatchResult& match, const FeatureMap& map) const {
  if (!match.pose.T_odom_sensor.IsFinite()) return false;
  const double least_share = map.IsYoung() ? 0 : options_.min_used_share;
  return match.seconded ||
         (match.used >= std::max<double>(options_.min_used, least_share * match.features) &&
          match.agreement >= options_.min_agreement);
}

bool Tracker::IsExpected(const ScanFrame& frame, const MatchResult& match,
                         const ScanPose& prediction) const {
  const Pose surprise = prediction.T_odom_sensor.Inverse() * match.pose.T_odom_sensor;
  if (surprise.translation().norm() < options_.max_surprise_m &&
      RotationAngle(surprise) < options_.max_surprise_rad) {
    return true;
  }
  const Vector6d away = Log(surprise);
  return away.dot(motion_.Displacement(SecondsBetween(frame)).ldlt().solve(away)) < kMostSurprise2;
}

void Tracker::AdoptMatch(const ScanFrame& frame, const FeatureMap& map, bool doubtful,
                         MatchResult* match) {
  if (options_.mode == OdometryMode::kFloam) {
    // Stage two of the paper: the motion that was found replaces the one that was predicted.
    const Pose moved = last_.pose.T_odom_sensor.Inverse() * match->pose.T_odom_sensor;
    match->pose.twist = Log(moved) / ElapsedSeconds(frame);
  }
  if (IsContinuous() && !IsAfterGap(frame)) {
    const Vector6d between =
        Log(last_.pose.T_odom_sensor.Inverse() * match->pose.T_odom_sensor) / SecondsBetween(frame);
    shared_twist_ += kTwistFading * (match->pose.twist - between - shared_twist_);
    match->pose.twist -= shared_twist_;
  }
  was_after_gap_ = IsAfterGap(frame);
  motion_.Update(SecondsBetween(frame), match->covariance.topLeftCorner<6, 6>());
  last_ = {match->pose, frame.stamp_ns};
  // Two scans from where a sensor was carried to agree with each other wherever they are put: one
  // that is in doubt supports none that follows, unless nothing else is to be had.
  keeps_last_ = !doubtful || IsSteady(frame);
  if (keeps_last_) scan_to_scan_.SetPrevious(frame.features);
  if (doubtful) return;
  degenerate_ = match->degeneracy.any();
  if (degenerate_) steady_until_ns_ = frame.stamp_ns + kSteadyNs;
  needs_last_ = map.IsYoung() || IsSteady(frame) || match->used < 0.5 * match->features;
  if (degenerate_) return;
  // With white noise on the acceleration, the square of the speed's distance from its fading
  // average is half the density times the time of fading, which is a second.
  const Eigen::Vector3d change = (match->pose.twist - steady_).head<3>();
  acceleration_ += kAccelerationFading * (2 * change.squaredNorm() - acceleration_);
  steady_ += kTwistFading * (match->pose.twist - steady_);
}

ScanPose Tracker::SteadyPrediction(const ScanFrame& frame, const Degeneracy& unobserved) const {
  ScanPose last = last_.pose;
  const auto settle = [&](const Eigen::Vector3d& d, int first) {
    const double change = d.dot(steady_.segment<3>(first) - last.twist.segment<3>(first));
    last.twist.segment<3>(first) += change * d;
  };
  for (const Eigen::Vector3d& d : unobserved.translations) settle(d, 0);
  for (const Eigen::Vector3d& d : unobserved.rotations) settle(d, 3);
  return Predict(last, ElapsedSeconds(frame), ReferenceTime(frame));
}

}  // namespace isthmus::floam
