#include "floam/tracker.h"

#include <algorithm>

namespace isthmus::floam {
namespace {

constexpr double kMaxExtrapolationS = 3;
constexpr double kMaxTiltingS = 0.3;  // A bump, or noise: robots do not go on tilting.
// Scans farther apart than this many periods: too much may have happened to trust the motion.
constexpr double kGapPeriods = 3.5;
constexpr double kSteadyFading = 0.1;
constexpr double kNearM = 2, kNearRad = 0.5;
constexpr double kGapTwistSigma = 1.0;  // m/s and rad/s, after a gap.

}  // namespace

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
  return IsContinuous() ? -0.5 * frame.period_s : 0;
}

double Tracker::Between(const ScanFrame& frame) const {
  return ElapsedSeconds(frame) + ReferenceTime(frame) - last_.pose.reference_s;
}

bool Tracker::IsAfterGap(const ScanFrame& frame) const {
  return ElapsedSeconds(frame) > kGapPeriods * sensor_.scan_period_s;
}

ScanPose Tracker::Prediction(const ScanFrame& frame) const {
  return Predict(last_.pose, ElapsedSeconds(frame), ReferenceTime(frame));
}

std::optional<TwistPrior> Tracker::Prior(const ScanFrame& frame, const ScanPose& guess) const {
  if (!IsContinuous()) return std::nullopt;
  TwistPrior prior;
  if (IsAfterGap(frame)) {
    prior.mean = guess.twist;
    prior.sigma.setConstant(kGapTwistSigma);
    return prior;
  }
  prior.T_odom_previous = last_.pose.T_odom_sensor;
  prior.since_previous_s = Between(frame);
  prior.sigma.head<3>().setConstant(options_.speed_change_sigma);
  prior.sigma.segment<2>(3).setConstant(options_.tilt_rate_sigma);
  prior.sigma[5] = options_.yaw_rate_change_sigma;
  return prior;
}

// Little of the ground may be in the map, and that far away and in single rings.
void Tracker::HoldWhileNew(const FeatureMap& map, Matrix6d* covariance) const {
  if (!map.IsNew()) return;
  const auto hold = [&](int k, double sigma) {
    const double variance = std::min((*covariance)(k, k), sigma * sigma);
    covariance->row(k).setZero();
    covariance->col(k).setZero();
    (*covariance)(k, k) = variance;
  };
  hold(2, options_.young_height_sigma_m);
  hold(3, options_.young_tilt_sigma_rad);
  hold(4, options_.young_tilt_sigma_rad);
}

PosePrior Tracker::Near(const Pose& T_odom_sensor, const FeatureMap& map) const {
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(kNearM * kNearM),
      Eigen::Vector3d::Constant(kNearRad * kNearRad);
  PosePrior prior{T_odom_sensor, variance.asDiagonal()};
  HoldWhileNew(map, &prior.covariance);
  return prior;
}

MatchResult Tracker::Match(const ScanFrame& frame, const ScanPose& guess, FeatureMap* map) {
  PosePrior prior{guess.T_odom_sensor, motion_.Displacement(Between(frame))};
  HoldWhileNew(*map, &prior.covariance);
  return matcher_.Match(frame.features, guess, prior, Prior(frame, guess), options_.matching,
                        map->surfaces(), map->edges());
}

MatchResult Tracker::MatchNear(const ScanFrame& frame, const ScanPose& guess,
                               const MatchOptions& options, FeatureMap* map) {
  return matcher_.Match(frame.features, guess, Near(guess.T_odom_sensor, *map), Prior(frame, guess),
                        options, map->surfaces(), map->edges());
}

void Tracker::Begin(const Sighting& sighting) {
  last_ = sighting;
  motion_ = MotionModel();
}

bool Tracker::Fits(const MatchResult& match, const FeatureMap& map) const {
  const double least_share = map.IsYoung() ? 0 : options_.min_used_share;
  return match.used >= std::max<double>(options_.min_used, least_share * match.features) &&
         match.agreement >= options_.min_agreement && match.pose.T_odom_sensor.IsFinite();
}

bool Tracker::IsExpected(const MatchResult& match, const ScanPose& prediction) const {
  const Pose surprise = prediction.T_odom_sensor.Inverse() * match.pose.T_odom_sensor;
  return surprise.translation().norm() < options_.max_surprise_m &&
         RotationAngle(surprise) < options_.max_surprise_rad;
}

void Tracker::Adopt(const ScanFrame& frame, const FeatureMap& map, MatchResult* match) {
  if (options_.mode == OdometryMode::kFloam) {
    // Stage two of the paper: the motion that was found replaces the one that was predicted.
    const Pose moved = last_.pose.T_odom_sensor.Inverse() * match->pose.T_odom_sensor;
    match->pose.twist = Log(moved) / ElapsedSeconds(frame);
  }
  // What a new map says of the tilt is held to the prediction: noise in its rate would add up.
  if (map.IsNew()) match->pose.twist.segment<2>(3).setZero();
  motion_.Update(Between(frame), match->covariance.topLeftCorner<6, 6>());
  last_ = {match->pose, frame.stamp_ns};
  degenerate_ = match->degeneracy.any();
  if (!degenerate_) steady_ += kSteadyFading * (match->pose.twist - steady_);
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
