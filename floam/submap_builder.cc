#include "floam/submap_builder.h"

#include <limits>
#include <utility>

#include "floam/adjoint.h"

namespace isthmus::floam {
namespace {

// Less than this is standing still: noise of the poses.
constexpr double kMovedM = 0.05;
constexpr double kMovedRad = 0.02;
constexpr size_t kMaxKeyframes = std::numeric_limits<uint16_t>::max();

}  // namespace

SubmapBuilder::SubmapBuilder(SessionId session, RobotId robot, const SubmapOptions& options,
                             uint32_t first_index)
    : session_(std::move(session)),
      robot_(std::move(robot)),
      options_(options),
      next_index_(first_index),
      thinner_(static_cast<float>(options.keyframe_voxel_m)) {}

std::shared_ptr<const Submap> SubmapBuilder::Add(const OdometryResult& result) {
  if (T_odom_begun_) drift_ += Carried(result.unobserved_covariance, result);
  if (result.status == TrackingStatus::kLost) return Finish();
  if (current_ == nullptr) {
    Begin(result);
  } else {
    travelled_m_ += (result.T_odom_sensor.translation() - T_odom_last_.translation()).norm();
    if (IsKeyframe(result)) AddKeyframe(result);
  }
  T_odom_last_ = result.T_odom_sensor;
  current_->last_sequence = result.sequence;
  current_->last_stamp_ns = result.stamp_ns;
  ++scans_;
  const bool full = travelled_m_ >= options_.cut_distance_m || scans_ >= options_.cut_scans ||
                    current_->keyframes.size() >= kMaxKeyframes;
  return full ? Cut() : nullptr;
}

std::shared_ptr<const Submap> SubmapBuilder::Finish() {
  return current_ == nullptr ? nullptr : Cut();
}

// The true T_begun_sensor is a product of steps, each T Exp(e) with its error e in the sensor frame
// at its end. With all that comes before moved to its right, it reads Exp(Ad(T_begun_sensor) e).
Matrix6d SubmapBuilder::Carried(const Matrix6d& covariance, const OdometryResult& result) const {
  const Matrix6d A = Adjoint(T_odom_begun_->Inverse() * result.T_odom_sensor);
  const Matrix6d carried = A * covariance * A.transpose();
  return 0.5 * (carried + carried.transpose());
}

void SubmapBuilder::Begin(const OdometryResult& result) {
  current_ = std::make_shared<Submap>();
  current_->id = {session_, next_index_};
  current_->robot = robot_;
  current_->T_odom_submap = result.T_odom_sensor;
  if (T_odom_begun_) {
    current_->drift_covariance = drift_ + Carried(result.matched_covariance, result);
  }
  T_odom_begun_ = result.T_odom_sensor;
  drift_ = result.matched_covariance;
  current_->first_sequence = result.sequence;
  current_->first_stamp_ns = result.stamp_ns;
  scans_ = 0;
  travelled_m_ = 0;
  AddKeyframe(result);
}

bool SubmapBuilder::IsKeyframe(const OdometryResult& result) const {
  const Pose moved = T_odom_keyframe_.Inverse() * result.T_odom_sensor;
  const double distance_m = moved.translation().norm();
  const double angle_rad = RotationAngle(moved);
  if (distance_m >= options_.keyframe_distance_m || angle_rad >= options_.keyframe_angle_rad) {
    return true;
  }
  const double elapsed_s = 1e-9 * static_cast<double>(result.stamp_ns - keyframe_ns_);
  return elapsed_s >= options_.keyframe_interval_s &&
         (distance_m > kMovedM || angle_rad > kMovedRad);
}

void SubmapBuilder::AddKeyframe(const OdometryResult& result) {
  const auto keyframe = static_cast<uint16_t>(current_->keyframes.size());
  const Pose T_submap_sensor = current_->T_odom_submap.Inverse() * result.T_odom_sensor;
  current_->keyframes.push_back({result.sequence, result.stamp_ns, T_submap_sensor});
  T_odom_keyframe_ = result.T_odom_sensor;
  keyframe_ns_ = result.stamp_ns;

  const Eigen::Matrix3f R = T_submap_sensor.RotationMatrix().cast<float>();
  const Eigen::Vector3f t = T_submap_sensor.translation().cast<float>();
  const auto max_range2 = static_cast<float>(options_.max_range_m * options_.max_range_m);
  thinner_.Clear();
  for (const Point& p : result.undistorted) {
    const Eigen::Vector3f position = p.Position();
    if (!(position.squaredNorm() <= max_range2)) continue;
    if (!thinner_.Insert(p.x, p.y, p.z)) continue;
    const Eigen::Vector3f q = R * position + t;
    current_->points.push_back({q.x(), q.y(), q.z(), p.intensity, keyframe});
  }
}

std::shared_ptr<const Submap> SubmapBuilder::Cut() {
  ++next_index_;
  return std::exchange(current_, nullptr);
}

}  // namespace isthmus::floam
