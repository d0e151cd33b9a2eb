// Contents of a backup, as counted when it was checked.
#pragma once

#include <cstdint>
#include <string>

namespace isthmus {

struct BackupContents {
  int64_t sessions = 0, submaps = 0, scans = 0, points = 0;
  int64_t damaged = 0;  // Records that cannot be read.
  std::string report;   // The output of `isthmus-server --check`.
};

}  // namespace isthmus
