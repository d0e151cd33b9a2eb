// Robots on bad links: each behind a proxy of its own.
#pragma once

#include "tests/faults/harness/fleet.h"

namespace isthmus::faults {

// The faults of the links, one after the other, while scans are pushed at a steady rate. An outage
// is gone through twice: with connections that are reset, and with ones that hang.
struct LinkFaultOptions {
  int resets = 6;  // Moments at which each connection is reset with a probability of 10 %.
  double stall_s = 2;
  double slow_s = 2, slow_bytes_per_s = 64'000;
  double outage_s = 3;
  bool half_open = true;
  double period_s = 0.1;  // Between two scans; the server has to keep up with all robots.
};

// Throws where there is nothing to test: no server, no folder.
Report SpoilLinks(const Setup& setup, const LinkFaultOptions& options);

}  // namespace isthmus::faults
