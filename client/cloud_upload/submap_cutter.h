// Submaps out of clouds with poses.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "client/cloud_upload/limits.h"
#include "core/geometry/voxel_thinner.h"
#include "core/map/trajectory.h"
#include "core/point_payload.h"
#include "core/records/submap_upload.h"

namespace isthmus::cloud_upload {

enum class CloudFrame : uint8_t { kSensor, kOdom };

struct CutOptions {
  CloudFrame frame = CloudFrame::kSensor;  // Frame of the points as given.
  // To be added to points in odom, m, as it was to the poses (PoseFile::moved_by).
  Eigen::Vector3d moved_by = Eigen::Vector3d::Zero();
  // A cloud is a keyframe after this much travel, turning or, while moving at all, time.
  double keyframe_m = kKeyframeStepM, keyframe_rad = kKeyframeTurnRad, keyframe_s = kKeyframePauseS;
  // A submap ends after this much way, so many clouds, this much time or before more points.
  double way_m = kSubmapWayM;
  int clouds = kSubmapClouds;
  double time_s = kSubmapTimeS;
  size_t points = kSubmapPoints;
  double voxel_m = kCloudVoxelM;  // One point per voxel and keyframe; 0: all.
  double range_m = kCloudRangeM;  // From the sensor; farther points are left out.
};

// InvalidArgument, naming the option of the command line, for a range or a voxel that is negative,
// not finite or beyond what the grid of voxels holds.
absl::Status CheckOptions(const CutOptions& options);

// Not thread safe. Holds one submap. The same clouds give the same submaps, bit by bit.
class SubmapCutter {
 public:
  // `options` passed CheckOptions.
  explicit SubmapCutter(const CutOptions& options);

  // Adds a cloud, seen from T_odom_sensor at the END of the scan. Returns the submaps that this
  // completes, in order: mostly none, more than one for clouds of more points than a submap. Their
  // session is empty, their indices count from 0; points are in the submap's frame, that of the
  // sensor at its first keyframe, as x y z intensity (float32) and keyframe (uint32). Points that
  // are not finite, not within the range, or at the sensor itself are left out; so is a whole cloud
  // that is no keyframe, or has no point left, which begins no submap. InvalidArgument for a cloud
  // that is not raw or has no x, y, z, and for a pose that is not finite; it changes nothing.
  absl::StatusOr<std::vector<SubmapUpload>> Add(const StampedPose& T_odom_sensor,
                                                const PointPayload& cloud);
  // The unfinished submap.
  std::optional<SubmapUpload> Finish();

  size_t keyframes() const { return keyframes_; }
  size_t points() const { return points_; }
  size_t without_points() const { return without_points_; }  // Clouds.
  double travelled_m() const { return travelled_m_; }

 private:
  struct Kept {
    Eigen::Vector3d in_odom;
    float intensity;
  };

  absl::Status Keep(const Pose& T_odom_sensor, const PointPayload& cloud);
  bool IsKeyframe(const StampedPose& at) const;
  bool IsFull(const StampedPose& at) const;
  void AddKeyframe(const StampedPose& at, std::vector<SubmapUpload>& completed);
  void BeginKeyframe(const StampedPose& at);
  SubmapUpload Cut();

  const CutOptions options_;
  std::optional<SubmapUpload> current_;
  StampedPose last_, keyframe_;  // T_odom_sensor.
  int64_t begun_ns_ = 0;
  double way_m_ = 0, travelled_m_ = 0;
  int clouds_ = 0;
  bool has_last_ = false;
  uint32_t next_index_ = 0;
  size_t keyframes_ = 0, points_ = 0, without_points_ = 0;
  std::vector<Kept> kept_;  // Scratch.
  VoxelThinner thinner_;    // Scratch.
};

}  // namespace isthmus::cloud_upload
