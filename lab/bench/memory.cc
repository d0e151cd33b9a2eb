#include "lab/bench/memory.h"

#include <malloc.h>
#include <sys/resource.h>

#include <fstream>
#include <string>

namespace isthmus::bench {
namespace {

// The number in a line such as "VmHWM:  1234 kB" of /proc/self/status; 0 where there is none.
double StatusMb(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (double kb = 0; word == name && status >> kb) return kb / 1e3;
  }
  return 0;
}

}  // namespace

double HeapMb() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / 1e6;
}

void ResetPeak() { std::ofstream("/proc/self/clear_refs") << "5"; }

double ResidentMb() { return StatusMb("VmRSS:"); }

double PeakMb() {
  if (const double mb = StatusMb("VmHWM:"); mb > 0) return mb;
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1e3;
}

}  // namespace isthmus::bench
