// A drive whose scans another program has compensated for motion.
#pragma once

#include <absl/status/statusor.h>

#include "lab/bench/drive.h"

namespace isthmus::bench {

// The same drive without its first turn, every point where it was at the END of its scan, by the
// true motion from the turn before, and with times of 0. Points without times have those of their
// azimuth, as the sensor model tells. NotFound for a sensor that is not known.
absl::StatusOr<Drive> Compensated(const Drive& drive);

}  // namespace isthmus::bench
