#include "bench/memory.h"

#include <malloc.h>
#include <sys/resource.h>

#include <fstream>
#include <string>

namespace isthmus::bench {

double HeapMb() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / 1e6;
}

void ResetPeak() { std::ofstream("/proc/self/clear_refs") << "5"; }

double PeakMb() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (double kb = 0; word == "VmHWM:" && status >> kb) return kb / 1e3;
  }
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1e3;
}

}  // namespace isthmus::bench
