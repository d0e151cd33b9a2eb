// The road map of a simulated world: a graph of straight stretches, and tours on it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lab/simulation/random.h"

namespace isthmus::simulation {

// Nodes joined by straight, drivable stretches. A place (a museum's room, a campus' block) is a
// cycle of nodes that shows all of it. Value type.
struct RoadMap {
  std::vector<Eigen::Vector2d> nodes;
  std::vector<bool> movable;  // A robot may pass the node at a little distance (not in a doorway).
  std::vector<std::vector<int>> neighbours;
  std::vector<std::vector<int>> places;

  int AddNode(const Eigen::Vector2d& position, bool is_movable);
  void Link(int a, int b);
  // Links the nodes in order, the last with the first, and makes them a place.
  int AddPlace(const std::vector<int>& cycle);
  Eigen::Vector2d Center(int place) const;
  // The length of the shortest way from any node of `from` (places) to each place; infinity if
  // there is none.
  std::vector<double> WalkingDistances(const std::vector<int>& from) const;
  // A robot that comes from `a` to `b` may go on to `c`: no turn of more than 120 degrees.
  bool CanTurn(int a, int b, int c) const;
  // Distance of a point to the nearest stretch.
  double Distance(const Eigen::Vector2d& point) const;
};

// A closed walk: `nodes` in order, the last one joined with the first.
struct ClosedWalk {
  std::vector<int> nodes;
  size_t done = 0;  // Index of the node at which all places have been seen; the rest leads back.
};

// A walk from the far side of the first of `places` to the far side of each of the others in order,
// and back to its first node. Every turn
// is one that CanTurn allows. No nodes if a place cannot be reached that way.
ClosedWalk Tour(const RoadMap& roads, const std::vector<int>& places, Random& random);

// The places of each robot's tour: `own` in a sector of its own, then `shared` around the middle of
// the map that every robot sees. Fewer if there are not enough.
std::vector<std::vector<int>> PlanTours(const RoadMap& roads, int robots, int own, int shared,
                                        Random& random);

}  // namespace isthmus::simulation
