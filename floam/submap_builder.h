// Cuts a session's drive into submaps.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/voxel_thinner.h"
#include "core/map/submap.h"
#include "floam/odometry.h"

namespace isthmus::floam {

struct SubmapOptions {
  double keyframe_distance_m = 1.0;  // A scan is kept after this much travel ...
  double keyframe_angle_rad = 0.35;  // ... or turning ...
  double keyframe_interval_s = 5.0;  // ... or, while moving at all, time.
  double keyframe_voxel_m = 0.15;    // One point per voxel and keyframe.
  double max_range_m = 60;           // Farther points are too sparse to match on.
  double cut_distance_m = 15;        // A submap ends after this much travel ...
  int cut_scans = 200;               // ... or this many scans.
  // Points are rounded to multiples of this, as the store does by default: what a submap holds is
  // then the same before and after a restart. 0: they are not.
  double resolution_m = 0.001;
};

// Not thread safe. Feed every result of the odometry, in order.
//
// A submap's drift_covariance, but for the first that this makes, is that of three things taken as
// independent: how well the first scan of the submap before lay on the odometry's map, how well its
// own first scan does, and what no scan observed of the motion in between, lost scans among them.
// The odometry cannot say how the map itself drifts meanwhile. Adding every scan's covariance, as
// if the one before were all it is matched to, would give ten times the errors seen in museums.
class SubmapBuilder {
 public:
  // Submaps are numbered from `first_index`.
  SubmapBuilder(SessionId session, RobotId robot, const SubmapOptions& options,
                uint32_t first_index = 0);

  // Returns the submap that this scan completed (and is part of), or null. A lost scan ends the
  // submap before it and is not kept as a keyframe.
  std::shared_ptr<const Submap> Add(const OdometryResult& result);
  // Cuts what is unfinished; null when there is nothing.
  std::shared_ptr<const Submap> Finish();
  // Index of the submap that the next scan falls into.
  uint32_t CurrentIndex() const { return next_index_; }

  // As Odometry's: with the unfinished submap, exactly.
  std::string Save() const;
  absl::Status Restore(const std::string& saved);
  // For state_codec.h: all but the unfinished submap.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.next_index_, self.T_odom_begun_, self.drift_, self.scans_, self.travelled_m_,
       self.T_odom_last_, self.T_odom_keyframe_, self.keyframe_ns_);
  }

 private:
  uint64_t Checksum() const;  // Checksum of the settings.
  Matrix6d TransportCovariance(const Matrix6d& covariance, const OdometryResult& result) const;
  void BeginSubmap(const OdometryResult& result);
  bool IsKeyframe(const OdometryResult& result) const;
  void AddKeyframe(const OdometryResult& result);
  std::shared_ptr<const Submap> CutSubmap();

  const SessionId session_;
  const RobotId robot_;
  const SubmapOptions options_;
  uint32_t next_index_;
  std::shared_ptr<Submap> current_;    // Null between submaps.
  std::optional<Pose> T_odom_begun_;   // Pose of the submap begun last.
  Matrix6d drift_ = Matrix6d::Zero();  // The sensor's drift since then, in its frame.
  int scans_ = 0;
  double travelled_m_ = 0;
  Pose T_odom_last_, T_odom_keyframe_;
  int64_t keyframe_ns_ = 0;
  VoxelThinner thinner_;  // Scratch.
};

}  // namespace isthmus::floam
