// A server's answers about its whole map, to be compared with what it says later.
#pragma once

#include <string>
#include <vector>

#include "client/library/client.h"

namespace isthmus::faults {

struct Answers {
  std::vector<SessionStatus> sessions;
  std::vector<SubmapStatus> submaps;
  std::vector<Trajectory> trajectories;  // By robot: in odom, then in the map.
  // Points of the whole map by component, in order of x, y and z.
  std::vector<std::vector<MapPoint>> points;
};

// Waits until the server has nothing left to do, and asks. Throws where it does not answer.
Answers AskAll(const std::string& address);

// The first that is not the same, in words; empty where all is.
std::string Difference(const Answers& wanted, const Answers& answers);

}  // namespace isthmus::faults
