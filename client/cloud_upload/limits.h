// Limits by which a trajectory of clouds is cut into submaps.
#pragma once

#include <cstddef>
#include <cstdint>

namespace isthmus::cloud_upload {

// Cutting: as the server's own odometry does it (SubmapOptions of floam/submap_builder.h), for
// which matching was tuned. Larger submaps bend with the drift in them, smaller ones overlap less.

// Metres, radians and seconds from one keyframe to the next.
inline constexpr double kKeyframeStepM = 1.0;
inline constexpr double kKeyframeTurnRad = 0.35;
inline constexpr double kKeyframePauseS = 5.0;
// Less motion than this, m and rad, is noise of the poses: a robot that stands makes no keyframes.
inline constexpr double kStandingM = 0.05;
inline constexpr double kStandingRad = 0.02;
// Metres of way, clouds and seconds after which a submap ends. 20 s is 200 scans at 10 Hz.
inline constexpr double kSubmapWayM = 15;
inline constexpr int kSubmapClouds = 200;
inline constexpr double kSubmapTimeS = 20;
// Points after which a submap ends. The server takes 4 million; this is 40 MB here and there.
inline constexpr size_t kSubmapPoints = 2'000'000;

// Several LiDARs.

// Nanoseconds between clouds of two LiDARs that are joined to one: half a turn at 10 Hz, and as
// much again as drivers are late.
inline constexpr int64_t kSameTurnNs = 75'000'000;

// Points.

// Metres: one point per voxel of this size and keyframe. Maps are matched at 0.2 m and composed at
// 0.1 m or more; half the voxel is eight times the bytes on even ground at most.
inline constexpr double kCloudVoxelM = 0.1;
// Metres: farther points are too sparse to match on; the server's own 60 m, and some for sensors
// that are denser than a VLP-16.
inline constexpr double kCloudRangeM = 80;
// Metres beyond which the grid of voxels ends (core/geometry/voxel_thinner.h).
inline constexpr double kGridRangeM = 500;
// Voxels of that grid along each axis: more, and far points would fall together with near ones.
inline constexpr double kGridVoxels = 16384;
// Metres: nearer points are those that drivers write for rays that never came back, at 0 0 0.
inline constexpr double kNoReturnM = 0.01;

// Poses.

// Nanoseconds: how far a cloud's stamp may be from that of a single pose: half the time of a scan
// at 10 Hz, in which a robot at walking pace goes 0.1 m.
inline constexpr int64_t kNearestPoseNs = 50'000'000;
// Nanoseconds between two poses that a pose is interpolated between: several scans, in which the
// motion is near enough to even. A guess.
inline constexpr int64_t kInterpolatedNs = 500'000'000;
// Metres and radians by which two poses of one instant may differ, as rounding makes them.
inline constexpr double kSamePoseM = 0.01, kSamePoseRad = 0.01;
// By how much a matrix of a KITTI file may miss a rotation: files have 7 digits or 3.
inline constexpr double kNoRotation = 0.01;

}  // namespace isthmus::cloud_upload
