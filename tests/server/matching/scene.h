// Small worlds of boxes, and what a spinning LiDAR makes of them: maps with known truth.
#pragma once

#include <memory>
#include <vector>

#include "core/map/submap.h"
#include "server/matching/pairs/matcher_options.h"

namespace isthmus::matching {

struct SceneBox {
  Eigen::Vector3d center, half_size;
  double yaw = 0;
};

// The box between two corners.
SceneBox Between(double x0, double y0, double z0, double x1, double y1, double z1);

struct Scene {
  std::vector<SceneBox> boxes;
  // Distance to the first box along the unit direction; negative when there is none.
  double Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;
};

// Three rooms and a hall, about 30 by 20 m and 4 m high, with doors and exhibits, no symmetry.
Scene MakeGallery();
// The gallery is small and mostly floor, and both robots see all of it: in earnest a twin of it
// would be feared.
MatcherOptions InTheGallery();

struct Drive {
  std::vector<Eigen::Vector3d> positions;  // Sensor positions, world frame.
  Pose T_world_odom;
  double noise_m = 0.01;
  unsigned seed = 1;
  int azimuths = 240;
  double max_range_m = 40;
};

// One submap per five positions.
SessionMap Survey(const Scene& scene, const Drive& drive);

// The submaps by an odometry that strays by `step` on its way to every submap but the first.
std::vector<std::shared_ptr<const Submap>> Stray(
    const std::vector<std::shared_ptr<const Submap>>& truth, const Pose& step);

// `count` positions evenly along the way through the corners given.
std::vector<Eigen::Vector3d> Way(const std::vector<Eigen::Vector3d>& corners, int count);

}  // namespace isthmus::matching
