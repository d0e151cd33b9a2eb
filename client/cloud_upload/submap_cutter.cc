#include "client/cloud_upload/submap_cutter.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/cloud_upload/columns.h"

namespace isthmus::cloud_upload {
namespace {

constexpr uint32_t kRecordBytes = 20;  // Format.

SubmapUpload EmptySubmap(uint32_t index, const StampedPose& first) {
  SubmapUpload submap;
  submap.id.index = index;
  submap.first_stamp_ns = submap.last_stamp_ns = first.stamp_ns;
  submap.T_odom_submap = first.pose;
  submap.cloud.fields = {{"x", 0, ScalarType::kFloat32, 1},
                         {"y", 4, ScalarType::kFloat32, 1},
                         {"z", 8, ScalarType::kFloat32, 1},
                         {"intensity", 12, ScalarType::kFloat32, 1},
                         {"keyframe", 16, ScalarType::kUint32, 1}};
  submap.cloud.stride = kRecordBytes;
  return submap;
}

double SecondsBetween(const StampedPose& a, const StampedPose& b) {
  return 1e-9 * std::abs(static_cast<double>(a.stamp_ns) - static_cast<double>(b.stamp_ns));
}

}  // namespace

absl::Status CheckOptions(const CutOptions& options) {
  if (!(options.range_m > 0) || options.range_m > kGridRangeM) {
    return absl::InvalidArgumentError(
        absl::StrCat("--max-range must be above 0 m and at most ", kGridRangeM, " m"));
  }
  const double least_voxel_m = 2 * options.range_m / kGridVoxels;
  if (options.voxel_m != 0 &&
      !(options.voxel_m >= least_voxel_m && options.voxel_m <= options.range_m)) {
    return absl::InvalidArgumentError(
        absl::StrCat("--voxel must be 0 (all points), or at least ", least_voxel_m,
                     " m with this --max-range, and no more than that"));
  }
  return absl::OkStatus();
}

SubmapCutter::SubmapCutter(const CutOptions& options)
    : options_(options),
      thinner_(static_cast<float>(options.voxel_m > 0 ? options.voxel_m : kCloudVoxelM)) {}

absl::StatusOr<std::vector<SubmapUpload>> SubmapCutter::Add(const StampedPose& T_odom_sensor,
                                                            const PointPayload& cloud) {
  const StampedPose& at = T_odom_sensor;
  if (!at.pose.IsFinite()) return absl::InvalidArgumentError("the pose is not finite");
  if (absl::Status status = Keep(at.pose, cloud); !status.ok()) return status;
  std::vector<SubmapUpload> completed;
  if (kept_.empty()) {
    ++without_points_;
    return completed;
  }
  const double step_m = has_last_ ? (at.pose.translation() - last_.pose.translation()).norm() : 0.0;
  travelled_m_ += step_m;
  if (current_) way_m_ += step_m;
  last_ = at;
  has_last_ = true;
  if (!current_ || IsKeyframe(at)) AddKeyframe(at, completed);
  ++clouds_;
  current_->first_stamp_ns = std::min(current_->first_stamp_ns, at.stamp_ns);
  current_->last_stamp_ns = std::max(current_->last_stamp_ns, at.stamp_ns);
  if (IsFull(at)) completed.push_back(Cut());
  return completed;
}

std::optional<SubmapUpload> SubmapCutter::Finish() {
  return current_ ? std::optional(Cut()) : std::nullopt;
}

// Into kept_.
absl::Status SubmapCutter::Keep(const Pose& T_odom_sensor, const PointPayload& cloud) {
  const auto columns = ReadColumns(cloud);
  if (!columns.ok()) return columns.status();
  const bool in_odom = options_.frame == CloudFrame::kOdom;
  const Pose T_sensor_odom = T_odom_sensor.Inverse();
  const bool has_intensity = !(*columns)[3].empty();
  kept_.clear();
  thinner_.Clear();
  for (size_t i = 0; i < (*columns)[0].size(); ++i) {
    Eigen::Vector3d given((*columns)[0][i], (*columns)[1][i], (*columns)[2][i]);
    if (in_odom) given += options_.moved_by;
    const Eigen::Vector3d in_sensor = in_odom ? T_sensor_odom * given : given;
    const double range_m = in_sensor.norm();  // Not finite where a coordinate is not.
    if (!(range_m > kNoReturnM && range_m <= options_.range_m)) continue;
    const Eigen::Vector3f p = in_sensor.cast<float>();
    if (options_.voxel_m > 0 && !thinner_.Insert(p.x(), p.y(), p.z())) continue;
    float intensity = has_intensity ? static_cast<float>((*columns)[3][i]) : 0.0F;
    if (!std::isfinite(intensity)) intensity = 0;
    kept_.push_back({in_odom ? given : T_odom_sensor * given, intensity});
  }
  return absl::OkStatus();
}

bool SubmapCutter::IsKeyframe(const StampedPose& at) const {
  const Pose moved = keyframe_.pose.Inverse() * at.pose;
  const double distance_m = moved.translation().norm();
  const double angle_rad = RotationAngle(moved);
  if (distance_m >= options_.keyframe_m || angle_rad >= options_.keyframe_rad) return true;
  return SecondsBetween(at, keyframe_) >= options_.keyframe_s &&
         (distance_m > kStandingM || angle_rad > kStandingRad);
}

bool SubmapCutter::IsFull(const StampedPose& at) const {
  return way_m_ >= options_.way_m || clouds_ >= options_.clouds ||
         SecondsBetween(at, {begun_ns_, {}}) >= options_.time_s;
}

void SubmapCutter::AddKeyframe(const StampedPose& at, std::vector<SubmapUpload>& completed) {
  if (current_ && current_->cloud.width + kept_.size() > options_.points) {
    completed.push_back(Cut());
  }
  BeginKeyframe(at);
  Pose T_submap_odom = current_->T_odom_submap.Inverse();
  for (const Kept& point : kept_) {
    if (current_->cloud.width == options_.points) {
      completed.push_back(Cut());
      BeginKeyframe(at);
      T_submap_odom = current_->T_odom_submap.Inverse();
    }
    const Eigen::Vector3f p = (T_submap_odom * point.in_odom).cast<float>();
    const float values[4] = {p.x(), p.y(), p.z(), point.intensity};
    const auto keyframe = static_cast<uint32_t>(current_->keyframes.size() - 1);
    std::string& data = current_->cloud.data;
    data.append(reinterpret_cast<const char*>(values), sizeof(values));
    data.append(reinterpret_cast<const char*>(&keyframe), sizeof(keyframe));
    ++current_->cloud.width;
  }
  points_ += kept_.size();
  ++keyframes_;
}

// In a submap that begins with it, where there is none.
void SubmapCutter::BeginKeyframe(const StampedPose& at) {
  if (!current_) {
    current_ = EmptySubmap(next_index_++, at);
    begun_ns_ = at.stamp_ns;
    way_m_ = 0;
    clouds_ = 0;
  }
  current_->keyframes.push_back({at.stamp_ns, current_->T_odom_submap.Inverse() * at.pose});
  keyframe_ = at;
}

SubmapUpload SubmapCutter::Cut() { return *std::exchange(current_, std::nullopt); }

}  // namespace isthmus::cloud_upload
