// Computing time of the calling thread.
#pragma once

#include <time.h>

namespace isthmus::bench {

// Starts on construction. Counts what this thread computes, not what it waits for, so that other
// programs on the machine disturb little.
class CpuClock {
 public:
  CpuClock() : start_(Now()) {}
  double Ms() const { return Now() - start_; }

 private:
  static double Now() {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
  }

  double start_;
};

}  // namespace isthmus::bench
