// The nearest surface along a ray, by Embree (Wald et al., "Embree: A Kernel Framework for
// Efficient CPU Ray Tracing", SIGGRAPH 2014).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>

#include "lab/simulation/sensors/mesh.h"

namespace isthmus::simulation {

struct Ray {
  Eigen::Vector3f origin;     // World frame.
  Eigen::Vector3f direction;  // Unit vector.
};

struct Hit {
  float range_m = -1;  // Negative if there is nothing within reach.
  float cosine = 0;    // For the angle between the ray and the surface's normal, in [0, 1].
  Material material = Material::kFloor;
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // Unit vector, world frame, to either side.
  bool moves = false;                                // It is of a person or a car, see Actors.
  PointClass surface = PointClass::kUnknown;         // Ground that is seen from below is ceiling.
};

// Thread safe after construction. Uses no threads of its own.
class RayCaster {
 public:
  // The mesh is copied.
  explicit RayCaster(const Mesh& mesh);
  ~RayCaster();
  RayCaster(const RayCaster&) = delete;
  RayCaster& operator=(const RayCaster&) = delete;

  // Fills hits[i] for rays[i]; both have the same size. Neighbouring rays should start close to
  // each other: they are cast in packets.
  void Cast(std::span<const Ray> rays, float max_range_m, std::span<Hit> hits) const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace isthmus::simulation
