// A ride: a carrier with a sensor on its way through a scene, and what goes wrong with it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lab/simulation/random.h"
#include "lab/simulation/simulator.h"
#include "lab/simulation/wild/further.h"
#include "lab/simulation/wild/scenes.h"

namespace isthmus::simulation::wild {

// The ride's way along a scene's path.
struct Way {
  double begin_m = 0;
  bool backwards = false;  // Against the path, `begin_m` before its end.
  double left_m = 0;       // Beside the path, to the rider's left.
  double above_m = 0;      // Above it: on another storey.
};

struct Ride {
  Carrier carrier;
  Lidar lidar;
  double seconds = 0;
  Way way;
  uint64_t seed = 0;  // For the noise.
  Truth truth = Truth::kNone;
  std::vector<Further> further = {};
};

// A simulator of the one robot, and words about it. `ride_random` shakes it, `fault_random` draws
// its faults.
struct Ridden {
  std::unique_ptr<Simulator> simulator;
  std::string about;
  double further_m = 0;  // See WildDrive, as the next.
  bool blocked = false;
};
Ridden MakeRide(const std::string& world, Scene scene, Ride ride, Random& ride_random,
                Random& fault_random);

}  // namespace isthmus::simulation::wild
