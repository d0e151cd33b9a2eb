// The share of the machine that a server takes, seen from outside.
#pragma once

#include <absl/status/statusor.h>
#include <sys/types.h>

#include <map>
#include <string>

namespace isthmus::loadgen {

struct ProcessUse {
  double cpu_s = 0;  // Since it began.
  double resident_mb = 0;
  int threads = 0;
  int files = 0;  // Open descriptors.
};

// Read from /proc; NotFound when there is no such process, or it is another user's.
absl::StatusOr<ProcessUse> UseOf(pid_t pid);

// CPU seconds of living threads since they began, by name. Empty if there is no such process.
std::map<std::string, double> ThreadCpuS(pid_t pid);

// Megabytes of the files below a folder; 0 where there is none.
double FolderMb(const std::string& folder);

}  // namespace isthmus::loadgen
