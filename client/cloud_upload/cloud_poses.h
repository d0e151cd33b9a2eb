// The poses of clouds: which pose of a trajectory is that of which cloud.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <optional>

#include "client/cloud_upload/limits.h"
#include "client/cloud_upload/pose_file.h"
#include "core/map/trajectory.h"

namespace isthmus::cloud_upload {

struct AssociationOptions {
  int64_t nearest_ns = kNearestPoseNs;
  int64_t interpolated_ns = kInterpolatedNs;
};

// The pose at an instant: that of two neighbours in time, interpolated, where they are at most
// `interpolated_ns` apart; else that of the nearest, if it is within `nearest_ns`; else none.
// `sorted` is in order of time.
std::optional<Pose> PoseAt(const Trajectory& sorted, int64_t stamp_ns,
                           const AssociationOptions& options);

// The clouds, as far as they are known before they are read.
struct CloudSeries {
  bool has_stamps = true;
  size_t first = 0;  // Index of the first one that is read, in the whole recording.
  std::optional<size_t> count = std::nullopt;  // Clouds that are read.
  bool is_part = false;                        // More may come after them.
};

// Thread safe.
class CloudPoses {
 public:
  // Clouds and poses are paired by their stamps where both have some, else in order, the i-th pose
  // with the i-th cloud of the recording; KITTI's and g2o's in order whenever there are as many
  // poses as clouds. InvalidArgument, saying how many there are of each and what would help, where
  // they are to be paired in order and their numbers differ.
  static absl::StatusOr<CloudPoses> Create(PoseFile file, const CloudSeries& clouds,
                                           const AssociationOptions& options);

  // T_odom_sensor of the index-th cloud of the recording; empty where it has none. The stamp is the
  // cloud's own; that of the pose where only that one has any.
  std::optional<StampedPose> Of(size_t index, int64_t stamp_ns) const;

  bool in_order() const { return in_order_; }
  // By stamp if they are paired so, else as in the file.
  const Trajectory& poses() const { return poses_; }

 private:
  CloudPoses() = default;

  Trajectory poses_;
  AssociationOptions options_;
  bool in_order_ = false, takes_stamps_ = false;
};

}  // namespace isthmus::cloud_upload
