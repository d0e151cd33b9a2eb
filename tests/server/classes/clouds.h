// Clouds of simple things, thinned about as maps are.
#pragma once

#include <Eigen/Core>
#include <random>
#include <vector>

namespace isthmus::classes {

using Cloud3 = std::vector<Eigen::Vector3f>;

// A rectangle from `corner` along two edges, a point every 0.1 m, 5 mm of noise.
inline void AddPatch(const Eigen::Vector3f& corner, const Eigen::Vector3f& along,
                     const Eigen::Vector3f& up, Cloud3* cloud) {
  std::mt19937 rng(static_cast<unsigned>(cloud->size()) + 1);
  std::normal_distribution<float> noise(0, 0.005F);
  const auto steps = [](const Eigen::Vector3f& edge) {
    return static_cast<int>(edge.norm() / 0.1F);
  };
  for (int i = 0; i < steps(along); ++i) {
    for (int k = 0; k < steps(up); ++k) {
      const Eigen::Vector3f p = corner +
                                (static_cast<float>(i) + 0.5F) * 0.1F * along.normalized() +
                                (static_cast<float>(k) + 0.5F) * 0.1F * up.normalized();
      cloud->push_back(p + Eigen::Vector3f(noise(rng), noise(rng), noise(rng)));
    }
  }
}

// The sides and the top of a box on the ground.
inline void AddBox(const Eigen::Vector3f& foot, const Eigen::Vector3f& size, Cloud3* cloud) {
  const Eigen::Vector3f x(size.x(), 0, 0), y(0, size.y(), 0), z(0, 0, size.z());
  AddPatch(foot, x, z, cloud);
  AddPatch(foot + y, x, z, cloud);
  AddPatch(foot, y, z, cloud);
  AddPatch(foot + x, y, z, cloud);
  AddPatch(foot + z, x, y, cloud);
}

// The parts of a room of 12 x 8 x 3 m with a corner at the origin, the floor at z = 0.
inline Cloud3 RoomFloor() {
  Cloud3 cloud;
  AddPatch({0, 0, 0}, {12, 0, 0}, {0, 8, 0}, &cloud);
  return cloud;
}
inline Cloud3 RoomCeiling() {
  Cloud3 cloud;
  AddPatch({0, 0, 3}, {12, 0, 0}, {0, 8, 0}, &cloud);
  return cloud;
}
inline Cloud3 RoomWalls() {
  Cloud3 cloud;
  AddPatch({0, 0, 0}, {12, 0, 0}, {0, 0, 3}, &cloud);
  AddPatch({0, 8, 0}, {12, 0, 0}, {0, 0, 3}, &cloud);
  AddPatch({0, 0, 0}, {0, 8, 0}, {0, 0, 3}, &cloud);
  AddPatch({12, 0, 0}, {0, 8, 0}, {0, 0, 3}, &cloud);
  return cloud;
}

// A way through the middle of the room, 0.8 m above its floor.
inline Cloud3 RoomSensors() {
  Cloud3 sensors;
  for (float x = 2; x < 10; ++x) sensors.push_back({x, 4, 0.8F});
  return sensors;
}

inline Cloud3 Joined(const std::vector<Cloud3>& clouds) {
  Cloud3 all;
  for (const Cloud3& cloud : clouds) all.insert(all.end(), cloud.begin(), cloud.end());
  return all;
}

}  // namespace isthmus::classes
