// The use that this process makes of the machine.
#pragma once

#include <cstdint>

namespace isthmus {

// Of the machine by the process; zeros where the system does not tell.
struct ProcessUse {
  double cpu_s = 0;  // Of all threads since its start, user and system.
  uint64_t resident_bytes = 0;
  uint64_t threads = 0;
  uint64_t open_files = 0, open_files_limit = 0;
};

namespace io {

// Asks the system; some microseconds, and one more for each open file.
ProcessUse UseOfThisProcess();

}  // namespace io

}  // namespace isthmus
