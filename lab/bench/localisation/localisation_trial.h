// A trial of localisation: one drive, from several starts, in the map of another.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "lab/bench/drive.h"
#include "lab/bench/merging/driven_robot.h"

namespace isthmus::bench {

struct LocalisationStart {
  double nearest_m = 0;    // To the way on which the map was made, when it began.
  int turn = 0;            // The drive's turn with which it begins.
  double first_s = -1;     // To the first pose; negative: none was given.
  double first_cpu_s = 0;  // Computing time up to then.
  double first_error_m = 0;
  bool was_ambiguous = false;
  int located = 0, uncertain = 0, scans = 0;
  int wrong = 0;                 // Located, but farther than Drive::wrong_m from the truth.
  std::vector<double> errors_m;  // While located.
};

struct LocalisationTrial {
  std::string name;
  size_t map_voxels = 0;
  double map_s = 0;                           // To make the map.
  double odometry_ms = 0, localising_ms = 0;  // Mean per scan that was followed.
  std::vector<LocalisationStart> starts;
};

// `same_ground`: poses can be judged; else every pose is wrong.
absl::StatusOr<LocalisationTrial> RunLocalisation(const DrivenRobot& map, const Drive& drive,
                                                  int starts, bool same_ground);

std::string ToText(const LocalisationTrial& trial);
std::string Summary(const std::vector<LocalisationTrial>& trials);

}  // namespace isthmus::bench
