// Two robots made of one recorded drive.
#pragma once

#include <absl/status/statusor.h>

#include "lab/bench/drive.h"
#include "lab/bench/merging/drive_options.h"

namespace isthmus::bench {

// Shots `from` to `to` of the drive, both included.
Drive PartOf(const Drive& drive, int from, int to);

// The drive as if it had been driven backwards in time: the last turn first, and within each turn
// the last point first, so that the sensor turns the other way round. Times and rings are those
// that the odometry itself infers for the scans in their own order, and are given to it; the true
// pose at the END of a turn is then that of its beginning. InvalidArgument for scans whose rings
// and times cannot be inferred.
absl::StatusOr<Drive> Backwards(const Drive& drive);

}  // namespace isthmus::bench
