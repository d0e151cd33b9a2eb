// Rooms that are filled with furniture, beside the ways that are walked.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "lab/simulation/random.h"
#include "lab/simulation/sensors/mesh.h"
#include "lab/simulation/wild/furniture.h"
#include "lab/simulation/wild/path.h"
#include "lab/simulation/wild/plan.h"
#include "lab/simulation/wild/season.h"

namespace isthmus::simulation::wild {

// Points of the ways, every 0.2 m.
std::vector<Eigen::Vector3d> Trodden(const std::vector<std::shared_ptr<const Path>>& ways);

// The taken parts of a floor: nothing stands nearer than `clear_m` to a trodden point of this
// floor, in another thing or outside.
class Floor {
 public:
  Floor(const Eigen::Vector2d& min, const Eigen::Vector2d& max, double z, double clear_m,
        const std::vector<Eigen::Vector3d>& trodden);

  // Takes the rectangle `size` around a spot if it is free.
  bool Take(const Spot& spot, const Eigen::Vector2d& size);
  // A free spot that was taken, of some that are tried: at a wall, the back to it, `gap_m` away;
  // anywhere, turned anyhow.
  std::optional<Spot> TakeAtWall(const Eigen::Vector2d& size, double gap_m, Random& random);
  std::optional<Spot> TakeAnywhere(const Eigen::Vector2d& size, Random& random);

  Eigen::Vector2d Size() const { return max_ - min_; }
  const Eigen::Vector2d& min() const { return min_; }
  double z() const { return z_; }

 private:
  struct Taken {
    Eigen::Vector2d middle, half;
    double yaw;
  };
  Eigen::Vector2d min_, max_;
  double z_, clear_m_;
  std::vector<Eigen::Vector2d> trodden_;
  std::vector<Taken> taken_;
};

// Fills a room of a use. Kitchens and baths are built in; all else is drawn by the season, with
// numbers from `first` on, a thousand at most.
void Furnish(RoomUse use, const Season& season, uint64_t first, Floor* floor, Mesh* mesh);

// Fills all rooms and corridors of all storeys, each of its own.
void FurnishPlan(const Plan& plan, const Season& season, double clear_m,
                 const std::vector<Eigen::Vector3d>& trodden, Mesh* mesh);

}  // namespace isthmus::simulation::wild
