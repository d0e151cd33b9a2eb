#include "floam/localise/localiser.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/stopwatch.h"
#include "floam/localise/limits.h"
#include "floam/match/degeneracy.h"
#include "floam/match/limits.h"
#include "floam/match/pose_covariance.h"
#include "floam/scan/scan_frame.h"

namespace isthmus::floam {
namespace {

MapMemoryOptions MemoryOptions() {
  MapMemoryOptions options;
  options.max_voxels = kMostMapVoxels;
  return options;
}

RelocaliserOptions SearchOptions() {
  RelocaliserOptions options;
  options.patience = 3;  // Enough for the odometry to know what is usual.
  options.spacing_growth = 1.5;
  options.max_spacing = 40;
  options.lookups_per_scan = 60'000'000;  // Nothing else is to be done meanwhile.
  return options;
}

PlaceCheckOptions CheckOptions(const OdometryOptions& options) {
  PlaceCheckOptions check;
  check.twist_sigma = options.speed_change_sigma;  // The odometry knows the motion.
  return check;
}

// A finished map holds every plane: a third of what the odometry needs is enough.
MatchOptions Sparse(MatchOptions options) {
  options.stride = kRoughStride;
  return options;
}

Matrix6d Diagonal(double m, double rad) {
  Vector6d sigma;
  sigma << m, m, m, rad, rad, rad;
  return Matrix6d(sigma.cwiseAbs2().asDiagonal());
}

// Largest sigma of a position.
double SigmaM(const Matrix6d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance.topLeftCorner<3, 3>());
  return std::sqrt(std::max(0.0, solver.eigenvalues()(2)));
}

}  // namespace

LocalisationMap::LocalisationMap(const Eigen::Quaterniond& R_level_map)
    : T_level_map_(R_level_map, Eigen::Vector3d::Zero()),
      memory_(std::make_shared<MapMemory>(MemoryOptions())) {}

void LocalisationMap::Add(const Submap& submap, const Pose& T_map_submap) {
  // MapMemory tells age by the index; here submaps are of several sessions.
  Submap aged = submap;
  aged.id.index = submaps_++;
  memory_->Add(aged, T_level_map_ * T_map_submap);
}

Localiser::Localiser(const SensorModel& sensor, const OdometryOptions& options)
    : options_(options),
      odometry_(sensor, options),
      relocaliser_(options.matching, SearchOptions(), options.R_base_sensor),
      check_(Sparse(options.matching), CheckOptions(options)) {}

void Localiser::SetMap(std::shared_ptr<const LocalisationMap> map, const Pose& T_new_old) {
  if (map_ != nullptr && T_level_odom_) {
    T_level_odom_ = map->T_level_map() * T_new_old * map_->T_level_map().Inverse() * *T_level_odom_;
  }
  map_ = std::move(map);
  relocaliser_.UseMemory(map_->memory());
  relocaliser_.Reset();
  check_.Clear();
}

void Localiser::SetMapAnew(std::shared_ptr<const LocalisationMap> map) {
  Forget();
  SetMap(std::move(map));
}

void Localiser::Forget() {
  T_level_odom_.reset();
  relocaliser_.Reset();
  contradicted_s_ = 0;
  fits_ = false;
}

// The known place grows less certain by the way.
void Localiser::Predict(const OdometryResult& odometry) {
  const Pose step = T_odom_last_.Inverse() * odometry.T_odom_sensor;
  const double way = step.translation().norm(), turn = RotationAngle(step);
  // From the sensor frame before to that of now.
  const Eigen::Matrix3d R = step.RotationMatrix().transpose();
  Matrix6d adjoint = Matrix6d::Zero();
  adjoint.topLeftCorner<3, 3>() = R;
  adjoint.bottomRightCorner<3, 3>() = R;
  adjoint.topRightCorner<3, 3>() = -R * Skew(step.translation());
  covariance_ = adjoint * covariance_ * adjoint.transpose();
  covariance_ += Diagonal(kDriftPerM * way, kDriftRadPerM * way + kDriftPerRad * turn);
  covariance_ += odometry.unobserved_covariance;
}

ScanPose Localiser::GuessAt(const Pose& T_level_sensor) const {
  ScanPose guess;
  guess.reference_s = odometry_.frame().MiddleS();
  guess.twist = twist_;
  guess.T_odom_sensor = T_level_sensor * Exp(guess.reference_s * twist_);
  return guess;
}

Localiser::Sight Localiser::Look(const PlaceMatch& place, const Pose& T_level_expected) const {
  const MatchQuality& usual = odometry_.quality();
  if (!place.match.pose.T_odom_sensor.IsFinite() || place.match.used < options_.min_used) {
    return Sight::kNothingThere;
  }
  const RelocaliserOptions search = SearchOptions();
  if (place.share < search.least_share) return Sight::kNothingThere;
  const double agreement =
      std::max(search.least_agreement, search.min_agreement * usual.agreement());
  const bool through =
      place.walls.count() > 0 && place.walls.through_share() > usual.through() + kMoreThroughMap;
  if (place.match.agreement < agreement || through) return Sight::kContradicts;
  const Pose surprise = T_level_expected.Inverse() * place.match.pose.At(0);
  const double sigma_rad = std::sqrt(std::max(0.0, covariance_.bottomRightCorner<3, 3>().trace()));
  if (surprise.translation().norm() > kGateM + kGateSigmas * SigmaM(covariance_) ||
      RotationAngle(surprise) > kGateRad + kGateSigmas * sigma_rad) {
    return Sight::kContradicts;
  }
  return Sight::kFits;
}

void Localiser::Correct(const PlaceMatch& place, const Pose& T_level_expected) {
  const Matrix6d measured =
      Widened(MatchedCovarianceAtEnd(place.match, true), DegeneracyAtEnd(place.match)) +
      Diagonal(kMapNoiseM, kMapNoiseRad);
  const Matrix6d gain = covariance_ * (covariance_ + measured).inverse();
  const Vector6d innovation = Log(T_level_expected.Inverse() * place.match.pose.At(0));
  const Pose T_level_sensor = T_level_expected * Exp(gain * innovation);
  T_level_odom_ = T_level_sensor * T_odom_last_.Inverse();
  covariance_ = (Matrix6d::Identity() - gain) * covariance_;
  covariance_ = 0.5 * (covariance_ + covariance_.transpose()).eval();
}

void Localiser::Follow(const OdometryResult& odometry) {
  const Pose T_level_expected = *T_level_odom_ * odometry.T_odom_sensor;
  const double elapsed_s = odometry_.frame().period_s;
  since_walls_s_ += elapsed_s;
  const bool with_walls = !fits_ || since_walls_s_ >= kWallsEveryS;
  if (with_walls) image_.Make(odometry_.frame().scan);
  if (with_walls) since_walls_s_ = 0;
  check_.SetScan(odometry_.frame(), image_);
  const PlaceMatch place =
      check_.Check(*map_->memory(), GuessAt(T_level_expected), /*is_rough=*/false, with_walls);
  const Sight sight = Look(place, T_level_expected);
  fits_ = sight == Sight::kFits;
  contradicted_s_ = sight == Sight::kContradicts ? contradicted_s_ + elapsed_s : 0;
  if (fits_) Correct(place, T_level_expected);
  if (contradicted_s_ > kContradictedS || SigmaM(covariance_) > kUnknownM) Forget();
}

void Localiser::Search(const OdometryResult& odometry) {
  const std::optional<MatchResult> found = relocaliser_.Find(
      odometry_.frame(), odometry.T_odom_sensor, odometry_.quality(), odometry_.frame().MiddleS());
  if (!found) return;
  const Pose T_level_sensor =
      Pose(options_.R_base_sensor, Eigen::Vector3d::Zero()) * found->pose.At(0);
  T_level_odom_ = T_level_sensor * odometry.T_odom_sensor.Inverse();
  covariance_ = Widened(MatchedCovarianceAtEnd(*found, true), DegeneracyAtEnd(*found)) +
                Diagonal(kMapNoiseM, kMapNoiseRad);
  relocaliser_.Reset();
  fits_ = true;
}

LocalisationStatus Localiser::Status() const {
  if (!T_level_odom_) {
    return relocaliser_.contested() ? LocalisationStatus::kAmbiguous
                                    : LocalisationStatus::kSearching;
  }
  return fits_ && SigmaM(covariance_) < kUncertainM ? LocalisationStatus::kLocated
                                                    : LocalisationStatus::kUncertain;
}

absl::StatusOr<LocalisationResult> Localiser::Process(const Scan& scan) {
  absl::StatusOr<OdometryResult> odometry = odometry_.Process(scan);
  if (!odometry.ok()) return odometry.status();
  const Stopwatch watch;
  LocalisationResult result;
  if (odometry->segment != segment_) {
    Forget();
    twist_.setZero();
  } else {
    const double elapsed_s = 1e-9 * static_cast<double>(odometry->stamp_ns - last_ns_);
    twist_ = Log(T_odom_last_.Inverse() * odometry->T_odom_sensor) / elapsed_s;
    Predict(*odometry);
  }
  segment_ = odometry->segment;
  T_odom_last_ = odometry->T_odom_sensor;
  last_ns_ = odometry->stamp_ns;
  if (map_ != nullptr) {
    if (T_level_odom_) {
      Follow(*odometry);
    } else {
      Search(*odometry);
    }
  }
  result.status = Status();
  if (T_level_odom_) {
    result.T_map_odom = map_->T_level_map().Inverse() * *T_level_odom_;
    result.T_map_sensor = result.T_map_odom * odometry->T_odom_sensor;
    result.covariance = covariance_;
  }
  result.odometry = *std::move(odometry);
  result.localising_ms = watch.Ms();
  return result;
}

}  // namespace isthmus::floam
