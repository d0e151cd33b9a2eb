// Memory of this process.
#pragma once

namespace isthmus::bench {

// Megabytes that are allocated and not freed. Differences between two moments tell what was kept.
double HeapMb();

// Megabytes that the process has in RAM now.
double ResidentMb();

// Forgets the peak so far, where the system allows it (Linux does).
void ResetPeak();
// Most memory, in megabytes, that the process had in RAM since ResetPeak.
double PeakMb();

}  // namespace isthmus::bench
