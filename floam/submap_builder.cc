#include "floam/submap_builder.h"

#include <cmath>
#include <limits>
#include <utility>

#include "core/geometry/se3.h"
#include "core/map/rounded.h"
#include "core/state_codec.h"
#include "floam/limits.h"
#include "floam/state/unfinished_submap.h"

namespace isthmus::floam {
namespace {

constexpr size_t kMaxKeyframes = std::numeric_limits<uint16_t>::max();  // Format of points.

constexpr char kBuilderMagic[] = "ISUB";
constexpr uint32_t kBuilderVersion = 1;  // Format.

}  // namespace

SubmapBuilder::SubmapBuilder(SessionId session, RobotId robot, const SubmapOptions& options,
                             uint32_t first_index)
    : session_(std::move(session)),
      robot_(std::move(robot)),
      options_(options),
      next_index_(first_index),
      thinner_(static_cast<float>(options.keyframe_voxel_m)) {}

std::shared_ptr<const Submap> SubmapBuilder::Add(const OdometryResult& result) {
  if (T_odom_begun_) drift_ += TransportCovariance(result.unobserved_covariance, result);
  if (result.status == TrackingStatus::kLost) return Finish();
  if (current_ == nullptr) {
    BeginSubmap(result);
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
  return full ? CutSubmap() : nullptr;
}

std::shared_ptr<const Submap> SubmapBuilder::Finish() {
  return current_ == nullptr ? nullptr : CutSubmap();
}

// The true T_begun_sensor is a product of steps, each T Exp(e) with its error e in the sensor frame
// at its end. With all that comes before moved to its right, it reads Exp(Ad(T_begun_sensor) e).
Matrix6d SubmapBuilder::TransportCovariance(const Matrix6d& covariance,
                                            const OdometryResult& result) const {
  const Matrix6d A = Adjoint(T_odom_begun_->Inverse() * result.T_odom_sensor);
  const Matrix6d transported = A * covariance * A.transpose();
  return 0.5 * (transported + transported.transpose());
}

void SubmapBuilder::BeginSubmap(const OdometryResult& result) {
  current_ = std::make_shared<Submap>();
  current_->id = {session_, next_index_};
  current_->robot = robot_;
  current_->T_odom_submap = result.T_odom_sensor;
  if (T_odom_begun_) {
    current_->drift_covariance = drift_ + TransportCovariance(result.matched_covariance, result);
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
    Eigen::Vector3f q = R * position + t;
    if (options_.resolution_m > 0) {
      q = q.unaryExpr([this](float v) { return Rounded(v, options_.resolution_m); });
    }
    current_->points.push_back({q.x(), q.y(), q.z(), p.intensity, keyframe});
  }
}

std::shared_ptr<const Submap> SubmapBuilder::CutSubmap() {
  ++next_index_;
  return std::exchange(current_, nullptr);
}

uint64_t SubmapBuilder::Checksum() const {
  StateWriter io;
  io(session_.value(), robot_.value(), options_.keyframe_distance_m, options_.keyframe_angle_rad,
     options_.keyframe_interval_s, options_.keyframe_voxel_m, options_.max_range_m,
     options_.cut_distance_m, options_.cut_scans, options_.resolution_m);
  const std::string bytes = io.Take();
  return StateChecksum(bytes.data(), bytes.size());
}

std::string SubmapBuilder::Save() const {
  StateWriter writer;
  Fields(*this, writer);
  writer(current_ != nullptr);
  if (current_ != nullptr) WriteUnfinished(*current_, writer);
  return SealState(kBuilderMagic, kBuilderVersion, Checksum(), writer.Take());
}

absl::Status SubmapBuilder::Restore(const std::string& saved) {
  absl::StatusOr<StateReader> reader =
      OpenState(kBuilderMagic, kBuilderVersion, Checksum(), saved, "the submap");
  if (!reader.ok()) return reader.status();
  SubmapBuilder restored(session_, robot_, options_);
  bool has_unfinished = false;
  Fields(restored, *reader);
  (*reader)(has_unfinished);
  if (has_unfinished) {
    restored.current_ = std::make_shared<Submap>();
    restored.current_->id = {session_, restored.next_index_};
    restored.current_->robot = robot_;
    ReadUnfinished(*reader, *restored.current_);
  }
  if (!reader->ok() || reader->remaining() > 0) {
    return absl::DataLossError("the state of the submap is damaged: it contradicts itself");
  }
  // The rest is constant or scratch.
  next_index_ = restored.next_index_;
  current_ = std::move(restored.current_);
  T_odom_begun_ = restored.T_odom_begun_;
  drift_ = restored.drift_;
  scans_ = restored.scans_;
  travelled_m_ = restored.travelled_m_;
  T_odom_last_ = restored.T_odom_last_;
  T_odom_keyframe_ = restored.T_odom_keyframe_;
  keyframe_ns_ = restored.keyframe_ns_;
  return absl::OkStatus();
}

}  // namespace isthmus::floam
