// Reading of the merged map: what to read, and the points that come.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "core/cloud.h"
#include "core/geometry/shape.h"
#include "core/ids.h"
#include "core/map/map_name.h"
#include "core/map/submap.h"
#include "core/map/trajectory.h"
#include "core/pose.h"

namespace isthmus {

struct SubmapStatus {
  SubmapInfo info;
  std::optional<uint32_t> component;  // Absent until the submap has been placed.
  Pose T_map_submap;                  // The submap's pose then.
};

enum class TrajectoryFrame { kOdom, kMap };

struct RobotTrajectory {
  // Poses of one segment follow each other.
  struct Part {
    uint32_t segment = 1;
    size_t count = 0;
  };

  SessionId session;  // The robot's newest, as it was opened.
  int64_t revision = 0;
  uint32_t component = 0;        // The component of the map frame.
  Trajectory poses;              // T_odom_sensor or T_map_sensor, in one frame, in order of time.
  std::vector<Part> parts = {};  // Parts of `poses`.
  std::vector<uint32_t> left_out = {};  // Segments that are not among them.
};

struct RobotTransform {
  int64_t revision = 0;
  Pose T_a_b;  // b's odom frame to a's, both as at their newest submaps.
};

// Parts of a map other than boxes and spheres; see core/geometry/shape.h.
struct OrientedBox {
  Pose T_map_box;        // Pose of its middle.
  Eigen::Vector3d size;  // Whole edges.
};
struct Polygon {
  std::vector<Eigen::Vector2d> corners;  // 3 at least.
  HeightBand heights = {};               // Heights in the map frame.
};
struct Corridor {
  std::vector<Eigen::Vector3d> path;  // One point at least.
  double width_m = 0;
  HeightBand heights = {};  // Relative to the path.
};
using RegionShape = std::variant<std::monostate, OrientedBox, Polygon, Corridor>;
// Null for none.
std::shared_ptr<const Shape> MakeShape(const RegionShape& shape);

// The position at which a query that was cut off goes on; the server's.
struct RegionPosition {
  uint64_t run = 0;
  int64_t revision = 0;
  uint64_t points = 0;  // Sent so far.
  double resolution_m = 0;
};

// The part of the merged map to read; without box, sphere and shape everything. Map frame.
struct RegionQuery {
  std::optional<Box> box = std::nullopt;
  struct Sphere {
    Eigen::Vector3d center;
    double radius_m;
  };
  std::optional<Sphere> sphere = std::nullopt;  // One of box, sphere and shape at most.
  RegionShape shape = {};
  MapName component = {};
  RobotId robot = {};       // Empty: all.
  double resolution_m = 0;  // One point per voxel of this size; 0: as composed.
  // At most so many points: the finest of the resolution and its doubles that allows for it. 0: no
  // limit.
  uint64_t max_points = 0;
  std::vector<SessionId> sessions = {};  // Sessions that saw the points last; empty: any.
  int64_t seen_from_ns = 0,
          seen_to_ns = 0;                // When they were seen last, ends included; 0: any time.
  std::vector<PointClass> classes = {};  // Classes of the points; empty: any.
  bool wants_intensity = true, wants_robot = true, wants_stamp = false, wants_label = false;
  // Sent compressed, coordinates rounded to so much; absent: as they are.
  std::optional<double> rounding_m = std::nullopt;
  // Compressed by Draco, to rounding_m or else 1 mm: for positions alone fewer bytes, but more
  // time, and within a chunk the points come in an order that says nothing.
  bool with_draco = false;
  std::optional<RegionPosition> resume = std::nullopt;  // Behind what came of this very query.
};

struct RegionChunk {
  int64_t revision = 0;
  std::vector<RobotId> robots;  // MapPoint::robot indexes it; the same in every chunk.
  std::vector<MapPoint> points;
  double resolution_m = 0;   // Resolution of the points; 0: as composed.
  RegionPosition next = {};  // Behind these points.
};

enum class ExportFormat {
  kPcdAscii,
  kPcdBinary,
  kPcdBinaryCompressed,
  kPly,
  kOctoMapBinary,  // .bt
  kOctoMapFull,    // .ot
};

// The edge of an OctoMap's leaves, metres: no finer than a LiDAR's noise, no coarser than a room.
inline constexpr double kLeastLeafM = 0.01, kMostLeafM = 10;

// An OctoMap has the voxels whose middle lies in box, sphere or shape, as rays of that robot found
// them.
struct ExportRequest {
  ExportFormat format = ExportFormat::kPcdBinaryCompressed;
  MapName component = {};
  double resolution_m = 0;  // Clouds: thinning, 0 as composed. OctoMap: leaf size, 0 for 0.2 m.
  std::optional<Box> box = std::nullopt;                     // Map frame.
  std::optional<RegionQuery::Sphere> sphere = std::nullopt;  // One of box, sphere and shape.
  RegionShape shape = {};
  RobotId robot = {};    // Empty: all.
  bool dropped = false;  // Clouds: what is not in the map, see ComposedMap::dropped, instead.
  std::vector<PointClass> classes = {};  // Clouds: of these classes; empty: of any.
};

}  // namespace isthmus
