// Reading of the merged map: what to read, and the points that come.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/cloud.h"
#include "core/ids.h"
#include "core/map/submap.h"
#include "core/map/trajectory.h"
#include "core/pose.h"

namespace isthmus {

struct SubmapStatus {
  SubmapInfo info;
  std::optional<uint32_t> component;  // Absent until the submap has been placed.
  Pose T_map_submap;                  // Where it lies then.
};

enum class TrajectoryFrame { kOdom, kMap };

struct RobotTrajectory {
  // Those of one segment follow each other.
  struct Part {
    uint32_t segment = 1;
    size_t count = 0;
  };

  SessionId session;  // The robot's newest, as it was opened.
  int64_t revision = 0;
  uint32_t component = 0;        // Of the map frame.
  Trajectory poses;              // T_odom_sensor or T_map_sensor, in one frame, in order of time.
  std::vector<Part> parts = {};  // Of `poses`.
  std::vector<uint32_t> left_out = {};  // Segments that are not among them.
};

struct RobotTransform {
  int64_t revision = 0;
  Pose T_a_b;  // b's odom frame to a's, both as at their newest submaps.
};

// The part of the merged map to read; without box and sphere everything. Map frame.
struct RegionQuery {
  std::optional<Box> box = std::nullopt;
  struct Sphere {
    Eigen::Vector3d center;
    double radius_m;
  };
  std::optional<Sphere> sphere = std::nullopt;  // Not together with a box.
  uint32_t component = 0;
  RobotId robot = {};       // Empty: all.
  double resolution_m = 0;  // One point per voxel of this size; 0: as composed.
};

struct RegionChunk {
  int64_t revision = 0;
  std::vector<RobotId> robots;  // MapPoint::robot indexes it; the same in every chunk.
  std::vector<MapPoint> points;
};

enum class ExportFormat {
  kPcdAscii,
  kPcdBinary,
  kPcdBinaryCompressed,
  kPly,
  kOctoMapBinary,  // .bt
  kOctoMapFull,    // .ot
};

// An OctoMap has the voxels whose middle lies in box or sphere, as rays of that robot found them.
struct ExportRequest {
  ExportFormat format = ExportFormat::kPcdBinaryCompressed;
  uint32_t component = 0;
  double resolution_m = 0;  // Clouds: thinning, 0 as composed. OctoMap: leaf size, 0 for 0.2 m.
  std::optional<Box> box = std::nullopt;                     // Map frame.
  std::optional<RegionQuery::Sphere> sphere = std::nullopt;  // Not together with a box.
  RobotId robot = {};                                        // Empty: all.
  bool dropped = false;  // Clouds: what is not in the map, see ComposedMap::dropped, instead.
};

}  // namespace isthmus
