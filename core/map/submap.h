// A submap: a stretch of one session's drive, the unit of storage, matching and composition.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/cloud.h"
#include "core/ids.h"
#include "core/pose.h"

namespace isthmus {

// A scan that was kept: where the sensor stood when it looked.
struct Keyframe {
  uint64_t sequence = 0;  // The scan it came from; 0 where a robot uploaded a finished submap.
  int64_t stamp_ns = 0;
  Pose T_submap_sensor;
};

// A point in the submap frame, and the keyframe that saw it. A keyframe's points are thinned
// within that keyframe only, so they are also a range image from where its sensor stood: that is
// what free-space checks and the orientation of normals rest on.
struct SubmapPoint {
  float x = 0, y = 0, z = 0;
  float intensity = 0;
  uint16_t keyframe = 0;  // Index into Submap::keyframes.

  Eigen::Vector3f Position() const { return {x, y, z}; }
};

// Immutable once cut; shared by pointer between threads.
struct Submap {
  SubmapId id;
  RobotId robot;
  Pose T_odom_submap;  // Pose of the first keyframe's sensor in odom.
  // The odometry's own estimate of its drift since the session's submap before: the covariance of
  // the twist by which the true T_before_this is Exp(twist) T_before_this. Zero: it says nothing.
  Matrix6d drift_covariance = Matrix6d::Zero();
  uint64_t first_sequence = 0;  // Scans covered, both ends included.
  uint64_t last_sequence = 0;
  int64_t first_stamp_ns = 0;
  int64_t last_stamp_ns = 0;
  std::vector<Keyframe> keyframes;  // At least one; at most 65535.
  std::vector<SubmapPoint> points;  // Grouped by keyframe, in ascending order of it.
};

// A submap without its points.
struct SubmapInfo {
  SubmapId id;
  RobotId robot;
  Pose T_odom_submap;
  Matrix6d drift_covariance = Matrix6d::Zero();  // As Submap's.
  uint64_t first_sequence = 0, last_sequence = 0;
  int64_t first_stamp_ns = 0, last_stamp_ns = 0;
  uint32_t keyframe_count = 0;
  uint64_t point_count = 0;
  Box bounds;  // Bounds of the points, in the submap frame.
  // ContentOf the submap as it came into the store; 0: not known, as it was stored by an older
  // version.
  uint64_t content = 0;
};

// Throws away the points; bounds and content are computed from them.
SubmapInfo Summarize(const Submap& submap);

// A hash over keyframes and points, bit for bit, which tells submaps apart that cover the same
// scans. Never 0.
uint64_t ContentOf(const Submap& submap);

// Fetches a submap with its points, from memory or from where it is stored. Null where it is gone
// or cannot be read. Thread safe.
using SubmapReader = std::function<std::shared_ptr<const Submap>(const SubmapId&)>;

// Bounds of the box after the transform (of its eight corners; empty stays empty).
Box Transform(const Pose& T_target_source, const Box& box);

// The map of one session in its odom frame: what two robots' matching is given.
struct SessionMap {
  SessionId session;
  // In order of index. With `points` they may be outlines: all but their points. They lie where
  // their T_odom_submap says, which may be corrected: as the session's loops have straightened it.
  std::vector<std::shared_ptr<const Submap>> submaps;
  SubmapReader points = nullptr;

  // The k-th with its points, lying where the outline lies; the outline where they cannot be read.
  std::shared_ptr<const Submap> Whole(size_t k) const;
};

}  // namespace isthmus
