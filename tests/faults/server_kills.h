// kill -9 of the server, again and again, under robots that stream.
#pragma once

#include "tests/faults/harness/fleet.h"

namespace isthmus::faults {

struct ServerKillOptions {
  int kills = 6;
  // One in so many comes while the server is starting.
  int startup_every = 5;
  uint64_t max_acks = 60;  // Between two starts, of all robots together.
};

// The robots drive until the last kill is done, then finish. Throws where there is nothing to test:
// no server, no folder.
Report KillServer(const Setup& setup, const ServerKillOptions& options);

}  // namespace isthmus::faults
