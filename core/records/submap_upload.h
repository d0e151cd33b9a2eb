// A finished submap of a robot that runs its own SLAM, still encoded.
#pragma once

#include <cstdint>
#include <vector>

#include "core/ids.h"
#include "core/map/trajectory.h"
#include "core/point_payload.h"
#include "core/pose.h"

namespace isthmus {

struct SubmapUpload {
  SubmapId id;  // The index-th of its session, from 0, without gaps.
  int64_t first_stamp_ns = 0, last_stamp_ns = 0;
  Pose T_odom_submap;
  // Poses of the sensor (T_submap_sensor); the cloud's field `keyframe` refers to them. May be
  // empty: then the sensor is taken to have stood at the submap's origin.
  std::vector<StampedPose> keyframes;
  PointPayload cloud;  // Submap frame; fields x, y, z at least.
};

}  // namespace isthmus
