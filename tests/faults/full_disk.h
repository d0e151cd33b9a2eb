// A disk that is full for a while.
#pragma once

#include "tests/faults/harness/fleet.h"

namespace isthmus::faults {

struct FullDiskOptions {
  int times = 1;           // Full, and free again.
  double full_s = 2;       // Seconds for which the disk is full.
  uint64_t max_acks = 60;  // Between two times, of all robots together.
};

// While the disk is full the server says so, calls nothing durable and serves readers; afterwards
// it goes on by itself, and nothing is lost. Throws where there is nothing to test.
Report FillDisk(const Setup& setup, const FullDiskOptions& options);

}  // namespace isthmus::faults
