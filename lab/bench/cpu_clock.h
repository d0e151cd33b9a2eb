// Computing time of the calling thread, or of all threads.
#pragma once

#include <time.h>

namespace isthmus::bench {

// Starts on construction. Counts what this thread computes, not what it waits for, so that other
// programs on the machine disturb little.
class CpuClock {
 public:
  enum class Of { kThread, kProcess };

  explicit CpuClock(Of of = Of::kThread)
      : clock_(of == Of::kThread ? CLOCK_THREAD_CPUTIME_ID : CLOCK_PROCESS_CPUTIME_ID),
        start_(Now()) {}
  double Ms() const { return Now() - start_; }

 private:
  double Now() const {
    timespec t;
    clock_gettime(clock_, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
  }

  clockid_t clock_;
  double start_;
};

}  // namespace isthmus::bench
