// The name and the priority of a thread, as the system's tools show them.
#pragma once

#include <string>

namespace isthmus {

// Names the calling thread; of longer names the first 15 characters.
void NameThread(const std::string& name);

// The calling thread, and those that it starts, give way to others of the process and of the
// machine: `nice` from 0 (none) to 19. On a machine that has time to spare nothing changes. Only
// ever more; without effect where the system does not allow it.
void LowerPriority(int nice);

}  // namespace isthmus
