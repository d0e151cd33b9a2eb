// kill -9 of the robots' programs, again and again.
#pragma once

#include "tests/faults/harness/fleet.h"

namespace isthmus::faults {

struct ClientKillOptions {
  int kills = 6;            // Kills of all robots together.
  int startup_every = 5;    // One in so many comes while the program is starting.
  uint64_t max_scans = 20;  // Pushed between two kills of a robot.
};

// Each robot drives until its share of the kills is done, then finishes. Throws where there is
// nothing to test: no server, no folder.
Report KillClients(const Setup& setup, const ClientKillOptions& options);

}  // namespace isthmus::faults
