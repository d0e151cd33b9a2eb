#include "floam/odometry.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/stopwatch.h"
#include "floam/features.h"
#include "floam/local_map.h"
#include "floam/odometry_options.h"
#include "floam/recovery.h"
#include "floam/ring_scan.h"
#include "floam/scan_matcher.h"
#include "floam/undistort.h"

namespace isthmus::floam {
namespace {

// Scans farther apart than this many periods: too much may have happened to trust the motion.
constexpr double kGapPeriods = 3.5;
constexpr int kStartIterations = 4;
constexpr double kStartKernelM = 1.0;
constexpr double kGapTwistSigma = 1.0;  // m/s and rad/s, after a gap.
// Recovery looks at every guess once, with a part of the features and a wide loss, ...
constexpr int kGlanceStride = 8;
constexpr double kGlanceKernelM = 0.5;
// ... and matches properly from the best.
constexpr size_t kRecoveryTries = 24;
constexpr int kTryStride = 3;
// Sigma along directions that are not observed, and of poses that are a prediction only.
constexpr double kUnobservedM = 1.0, kUnobservedRad = 0.2;
constexpr double kLostM = 10, kLostRad = 1;

Matrix6d Adjoint(const Pose& pose) {
  const Eigen::Matrix3d R = pose.RotationMatrix();
  Matrix6d adjoint;
  adjoint << R, Skew(pose.translation()) * R, Eigen::Matrix3d::Zero(), R;
  return adjoint;
}

// Of the pose at the END of the scan, from that of pose and twist at the reference time.
Matrix6d CovarianceAtEnd(const MatchResult& match, bool with_twist) {
  const double ahead_s = -match.pose.reference_s;
  Eigen::Matrix<double, 6, 12> J = Eigen::Matrix<double, 6, 12>::Zero();
  J.leftCols<6>() = Adjoint(Exp(-ahead_s * match.pose.twist));
  if (with_twist) J.rightCols<6>() = ahead_s * Matrix6d::Identity();
  Matrix12d covariance = match.covariance;
  for (const Eigen::Vector3d& d : match.degeneracy.translations) {
    covariance.topLeftCorner<3, 3>() += kUnobservedM * kUnobservedM * d * d.transpose();
  }
  for (const Eigen::Vector3d& d : match.degeneracy.rotations) {
    covariance.block<3, 3>(3, 3) += kUnobservedRad * kUnobservedRad * d * d.transpose();
  }
  return J * covariance * J.transpose();
}

// The unobserved directions of the pose at the reference time, as seen at the END of the scan.
Degeneracy AtEnd(const MatchResult& match) {
  const Eigen::Matrix3d R_end_reference =
      Exp(match.pose.reference_s * match.pose.twist).RotationMatrix();
  Degeneracy degeneracy = match.degeneracy;
  for (Eigen::Vector3d& d : degeneracy.translations) d = R_end_reference * d;
  for (Eigen::Vector3d& d : degeneracy.rotations) d = R_end_reference * d;
  return degeneracy;
}

Matrix6d LostCovariance() {
  Vector6d variance;
  variance.head<3>().setConstant(kLostM * kLostM);
  variance.tail<3>().setConstant(kLostRad * kLostRad);
  return variance.asDiagonal();
}

}  // namespace

struct Odometry::State {
  State(const SensorModel& sensor_model, const OdometryOptions& odometry_options)
      : sensor(sensor_model),
        options(odometry_options),
        extractor(odometry_options.features),
        surface_map(ShapeKind::kPlane, odometry_options.map),
        edge_map(ShapeKind::kLine, odometry_options.map) {}

  const SensorModel sensor;
  const OdometryOptions options;

  RingSorter sorter;
  FeatureExtractor extractor;
  ScanMatcher matcher;
  LocalMap surface_map, edge_map;
  RingScan scan;      // The one being processed.
  Features features;  // Of `scan`.

  int matched_scans = 0;      // Including the first.
  int64_t last_stamp_ns = 0;  // Of the last scan taken.
  Features first_features;    // Of the first scan, until the second has shown how it moved.

  // The last scan that was matched; where it was, and when. In kFloam its reference is the END of
  // the scan, in kContinuous the middle.
  ScanPose last;
  int64_t matched_stamp_ns = 0;
  MatchQuality quality;

  Pose T_odom_in_map;  // END of the last scan that went into the map.
  int scans_in_map = 0;

  bool continuous() const { return options.mode == OdometryMode::kContinuous; }
  double ReferenceTime() const { return continuous() ? -0.5 * scan.period_s : 0; }
  double SecondsSinceMatch(const Scan& input) const {
    return 1e-9 * static_cast<double>(input.end_stamp_ns - matched_stamp_ns);
  }

  absl::Status Prepare(const Scan& input);
  void Start();
  MatchOptions Matching() const;
  MatchResult StartMoving(double elapsed_s);
  MatchResult Track(double elapsed_s);
  MatchResult Recover(double elapsed_s);
  MatchResult MatchFrom(const ScanPose& guess, double elapsed_s, MatchOptions matching);
  bool Accepted(const MatchResult& match, const ScanPose* prediction) const;
  void Adopt(MatchResult* match, double elapsed_s, const Scan& input);
  void UpdateMap();
  void InsertIntoMap(const Features& points, const ScanPose& pose);
};

absl::Status Odometry::State::Prepare(const Scan& input) {
  double period_s = sensor.scan_period_s;
  if (matched_scans > 0) {
    if (input.end_stamp_ns <= last_stamp_ns) {
      return absl::InvalidArgumentError(
          absl::StrCat("scan ", input.sequence, " ends at ", input.end_stamp_ns,
                       " ns, not after the scan before it (", last_stamp_ns,
                       " ns); scans must come in order of time"));
    }
    // The time between stamps is the better period, unless scans were dropped.
    const double between_s = 1e-9 * static_cast<double>(input.end_stamp_ns - last_stamp_ns);
    if (std::abs(between_s - period_s) < 0.25 * period_s) period_s = between_s;
  }
  if (absl::Status status = sorter.Sort(input, sensor, period_s, &scan); !status.ok()) {
    return status;
  }
  extractor.Extract(scan, &features);
  if (matched_scans == 0 && static_cast<int>(features.surfaces.size()) < options.min_used) {
    return absl::InvalidArgumentError(absl::StrCat(
        "scan ", input.sequence, " shows only ", features.surfaces.size(), " surface points, of ",
        options.min_used, " needed to begin with; is the view blocked or the sensor model wrong?"));
  }
  return absl::OkStatus();
}

void Odometry::State::Start() {
  last = ScanPose{Pose(), Vector6d::Zero(), ReferenceTime()};
  first_features = features;
  InsertIntoMap(features, last);
  scans_in_map = 1;
  matched_scans = 1;
}

MatchOptions Odometry::State::Matching() const {
  MatchOptions matching = options.matching;
  if (scans_in_map < options.map_first_scans) {
    matching.guess_sigma[2] = options.young_height_sigma_m;
    matching.guess_sigma.segment<2>(3).setConstant(options.young_tilt_sigma_rad);
  }
  return matching;
}

// The motion within the first scan is only known once the second is matched to it, which depends on
// that motion: taken to be constant over both, it is found by repetition.
MatchResult Odometry::State::StartMoving(double elapsed_s) {
  MatchOptions matching = Matching();
  matching.kernel_start_m = kStartKernelM;
  MatchResult match;
  for (int iteration = 0; iteration < kStartIterations; ++iteration) {
    surface_map.Clear();
    edge_map.Clear();
    last.T_odom_sensor = Exp(last.reference_s * last.twist);
    InsertIntoMap(first_features, last);
    match = matcher.Match(features, Predict(last, elapsed_s, ReferenceTime()), std::nullopt,
                          matching, &surface_map, &edge_map);
    if (!Accepted(match, nullptr)) break;
    const double between_s = elapsed_s + match.pose.reference_s - last.reference_s;
    last.twist = Log(last.T_odom_sensor.Inverse() * match.pose.T_odom_sensor) / between_s;
    match.pose.twist = last.twist;
  }
  return match;
}

MatchResult Odometry::State::MatchFrom(const ScanPose& guess, double elapsed_s,
                                       MatchOptions matching) {
  std::optional<TwistPrior> prior;
  if (continuous()) {
    prior.emplace();
    if (elapsed_s < kGapPeriods * sensor.scan_period_s) {
      prior->T_odom_previous = last.T_odom_sensor;
      prior->since_previous_s = elapsed_s + guess.reference_s - last.reference_s;
      prior->sigma.head<3>().setConstant(options.speed_change_sigma);
      prior->sigma.segment<2>(3).setConstant(options.tilt_rate_sigma);
      prior->sigma[5] = options.yaw_rate_change_sigma;
    } else {
      prior->mean = guess.twist;
      prior->sigma.setConstant(kGapTwistSigma);
    }
  }
  return matcher.Match(features, guess, prior, matching, &surface_map, &edge_map);
}

MatchResult Odometry::State::Track(double elapsed_s) {
  return MatchFrom(Predict(last, elapsed_s, ReferenceTime()), elapsed_s, Matching());
}

MatchResult Odometry::State::Recover(double elapsed_s) {
  const auto score = [](const MatchResult& match) { return match.agreement * match.used; };
  MatchOptions glance = options.matching;
  glance.stride = kGlanceStride;
  glance.max_iterations = 1;
  glance.kernel_start_m = kGlanceKernelM;
  std::vector<std::pair<double, ScanPose>> ranked;
  for (const ScanPose& guess : RecoveryGuesses(last, elapsed_s, ReferenceTime())) {
    ranked.emplace_back(
        score(matcher.Match(features, guess, std::nullopt, glance, &surface_map, &edge_map)),
        guess);
  }
  const size_t tries = std::min(kRecoveryTries, ranked.size());
  std::partial_sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(tries),
                    ranked.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  MatchOptions attempt = options.matching;
  attempt.stride = kTryStride;
  attempt.kernel_start_m = kGlanceKernelM;
  MatchResult best;
  for (size_t k = 0; k < tries; ++k) {
    MatchResult match =
        matcher.Match(features, ranked[k].second, std::nullopt, attempt, &surface_map, &edge_map);
    if (k == 0 || score(match) > score(best)) best = std::move(match);
  }
  return MatchFrom(best.pose, elapsed_s, options.matching);
}

bool Odometry::State::Accepted(const MatchResult& match, const ScanPose* prediction) const {
  // A map of a few scans is sparse: most of what a scan sees is not in it yet.
  const double least_share = scans_in_map < options.map_first_scans ? 0 : options.min_used_share;
  if (match.used < std::max<double>(options.min_used, least_share * match.features)) return false;
  if (!(match.agreement >= options.min_agreement) || !match.pose.T_odom_sensor.IsFinite()) {
    return false;
  }
  if (prediction == nullptr) return true;
  const Pose surprise = prediction->T_odom_sensor.Inverse() * match.pose.T_odom_sensor;
  return surprise.translation().norm() < options.max_surprise_m &&
         RotationAngle(surprise) < options.max_surprise_rad;
}

void Odometry::State::Adopt(MatchResult* match, double elapsed_s, const Scan& input) {
  if (!continuous()) {
    // Stage two of the paper: the motion that was found replaces the one that was predicted.
    match->pose.twist = Log(last.T_odom_sensor.Inverse() * match->pose.T_odom_sensor) / elapsed_s;
  }
  last = match->pose;
  matched_stamp_ns = input.end_stamp_ns;
  ++matched_scans;
}

void Odometry::State::UpdateMap() {
  const Pose T_odom_end = last.At(0);
  const Pose moved = T_odom_in_map.Inverse() * T_odom_end;
  if (scans_in_map >= options.map_first_scans &&
      moved.translation().norm() < options.map_distance_m &&
      RotationAngle(moved) < options.map_angle_rad) {
    return;
  }
  InsertIntoMap(features, last);
  surface_map.Evict(T_odom_end.translation());
  edge_map.Evict(T_odom_end.translation());
  T_odom_in_map = T_odom_end;
  ++scans_in_map;
}

void Odometry::State::InsertIntoMap(const Features& points, const ScanPose& pose) {
  const ScanMotion motion(pose.twist, pose.reference_s, -scan.period_s, 0);
  const Eigen::Matrix3d R = pose.T_odom_sensor.RotationMatrix();
  const Eigen::Vector3d& t = pose.T_odom_sensor.translation();
  const auto insert = [&](const std::vector<TimedPoint>& from, LocalMap* map) {
    for (const TimedPoint& p : from) {
      map->Insert(R * motion.ToReference(p.position, p.time).cast<double>() + t);
    }
  };
  insert(points.map_surfaces, &surface_map);
  insert(points.edges, &edge_map);
}

Odometry::Odometry(const SensorModel& sensor, const OdometryOptions& options)
    : state_(std::make_unique<State>(sensor, options)) {}

Odometry::~Odometry() = default;

void Odometry::Resume(const Cloud& map_odom, const Trajectory& recent) {
  State& state = *state_;
  for (const Point& p : map_odom) state.surface_map.Insert(p.Position().cast<double>());
  const StampedPose& end = recent.back();
  state.last.reference_s = state.continuous() ? -0.5 * state.sensor.scan_period_s : 0;
  if (recent.size() > 1) {
    const StampedPose& before = recent[recent.size() - 2];
    const double elapsed_s = 1e-9 * static_cast<double>(end.stamp_ns - before.stamp_ns);
    if (elapsed_s > 0) state.last.twist = Log(before.pose.Inverse() * end.pose) / elapsed_s;
  }
  state.last.T_odom_sensor = end.pose * Exp(state.last.reference_s * state.last.twist);
  state.last_stamp_ns = state.matched_stamp_ns = end.stamp_ns;
  state.T_odom_in_map = end.pose;
  state.scans_in_map = state.options.map_first_scans;
  state.matched_scans = 2;  // Under way: the motion is known, nothing has to be guessed from rest.
}

absl::StatusOr<OdometryResult> Odometry::Process(const Scan& input) {
  State& state = *state_;
  const Stopwatch total;
  Stopwatch stage;
  OdometryResult result;
  result.sequence = input.sequence;
  result.stamp_ns = input.end_stamp_ns;
  if (absl::Status status = state.Prepare(input); !status.ok()) return status;
  result.rings_from = state.scan.rings_from;
  result.times_from = state.scan.times_from;
  result.timing.features_ms = stage.Lap();

  ScanPose pose;
  if (state.matched_scans == 0) {
    state.Start();
    state.matched_stamp_ns = input.end_stamp_ns;
    pose = state.last;
  } else {
    const double elapsed_s = state.SecondsSinceMatch(input);
    const ScanPose prediction = Predict(state.last, elapsed_s, state.ReferenceTime());
    const bool starting = state.matched_scans == 1;
    const bool gap = elapsed_s > kGapPeriods * state.sensor.scan_period_s;
    MatchResult match = starting ? state.StartMoving(elapsed_s) : state.Track(elapsed_s);
    bool accepted = state.Accepted(match, starting ? nullptr : &prediction);
    if (!starting && gap) accepted = accepted && state.quality.IsTypical(match);
    if (!starting && !accepted) {
      match = state.Recover(elapsed_s);
      accepted = state.Accepted(match, nullptr) && state.quality.IsTypical(match);
    } else if (accepted) {
      state.quality.Add(match);
    }
    if (accepted) {
      state.Adopt(&match, elapsed_s, input);
      pose = state.last;
      result.covariance = CovarianceAtEnd(match, state.continuous());
      result.degeneracy = AtEnd(match);
      result.status = match.degeneracy.any() ? TrackingStatus::kDegenerate : TrackingStatus::kOk;
    } else {
      pose = prediction;
      result.covariance = LostCovariance();
      result.status = TrackingStatus::kLost;
    }
    result.timing.matching_ms = stage.Lap();
    if (accepted) state.UpdateMap();
    result.timing.map_ms = stage.Lap();
  }
  state.last_stamp_ns = input.end_stamp_ns;
  result.T_odom_sensor = pose.At(0);
  if (state.options.undistort_cloud) {
    const ScanMotion motion(pose.twist, 0, -state.scan.period_s, 0);
    Undistort(state.scan, motion, &result.undistorted);
  }
  result.timing.matching_ms += stage.Lap();
  result.timing.total_ms = total.Ms();
  return result;
}

}  // namespace isthmus::floam
