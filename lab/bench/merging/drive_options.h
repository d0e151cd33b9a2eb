// The settings of one simulated robot's drive.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "lab/bench/drive.h"
#include "lab/simulation/wild/wild.h"

namespace isthmus::bench {

struct DriveOptions {
  // See simulation::MakeWorld; wild-KIND is one of a team, see simulation::WildTeam: of what
  // follows it has seed, seconds, robots, robot, sensor, and the options of wild worlds only.
  std::string world = "museum";
  uint64_t seed = 1;  // Seed of the world, the routes and the noise.
  double seconds = 60;
  int laps = 0;          // Times around a tour of about `seconds` and back; 0: not back, no longer.
  double speed_mps = 0;  // At most; 0: the world's own.
  int robots = 2;        // Number of robots in that world ...
  int robot = 0;         // ... and which of them this is.
  int walkers = 0, cars = 0, parked = 0;
  int day = 1, moved = 0;  // See simulation::Options.
  double tilt_deg = 0;     // The sensor is mounted askew by so much about x and y.
  std::string sensor = "vlp16";
  simulation::Truth truth = simulation::Truth::kNone;  // In points of any world.
  // Options of a wild world; see simulation::WildTeam.
  simulation::WildTwin twin = simulation::WildTwin::kNone;
  bool bare = false, first_day = false;
  std::vector<simulation::Further> further = {};

  // The same for equal options only; fit to be the name of a folder.
  std::string Key() const;
  // Robots of the same ground have a common truth.
  std::string Ground() const;
};

// A drive through the server, and what it is judged by.
struct GroundedDrive {
  Drive drive;
  std::string ground;         // Truths of drives on one ground are in one frame.
  double overlap_cell_m = 1;  // Size of surface that counts as one when views are compared.
  double further_m = 0;       // See simulation::WildDrive.
  bool blocked = false;
};

// InvalidArgument for a world or sensor that does not exist.
absl::StatusOr<GroundedDrive> SimulateDrive(const DriveOptions& options);

}  // namespace isthmus::bench
