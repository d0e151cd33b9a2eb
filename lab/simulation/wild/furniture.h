// Shapes of furniture and parked cars.
#pragma once

#include <Eigen/Core>

#include "lab/simulation/random.h"
#include "lab/simulation/sensors/mesh.h"

namespace isthmus::simulation::wild {

// The place of a piece: the middle of its foot. It is turned by `yaw`; its own y axis is its front.
struct Spot {
  Eigen::Vector3d foot;
  double yaw = 0;

  // A point in the piece's own axes.
  Eigen::Vector3d At(double x, double y, double z) const;
  Spot Beside(double x, double y, double turned) const { return {At(x, y, 0), yaw + turned}; }
};

// All fill the box `size` about; what `random` draws are boards, books and cushions.
void AddTable(const Spot& spot, const Eigen::Vector3d& size, Mesh* mesh);
void AddChair(const Spot& spot, Random& random, Mesh* mesh);
void AddSwivelChair(const Spot& spot, Random& random, Mesh* mesh);
void AddDesk(const Spot& spot, const Eigen::Vector3d& size, Random& random, Mesh* mesh);
void AddBed(const Spot& spot, const Eigen::Vector3d& size, Random& random, Mesh* mesh);
void AddSofa(const Spot& spot, const Eigen::Vector3d& size, Random& random, Mesh* mesh);
void AddShelf(const Spot& spot, const Eigen::Vector3d& size, Random& random, Mesh* mesh);
void AddKitchenLine(const Spot& spot, double width_m, Random& random, Mesh* mesh);
void AddPlantPot(const Spot& spot, double height_m, Random& random, Mesh* mesh);
void AddLamp(const Spot& spot, double height_m, Mesh* mesh);
// One or more, each on the other.
void AddCartons(const Spot& spot, double side_m, Random& random, Mesh* mesh);

// A car of a model that `random` draws, small to large or a van; x ahead.
void AddParkedCar(const Eigen::Vector3d& on_ground, double yaw, Random& random, Mesh* mesh);

}  // namespace isthmus::simulation::wild
