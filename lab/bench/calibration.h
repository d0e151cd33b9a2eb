// The unit "cal" that costs are told in.
#pragma once

namespace isthmus::bench {

// CPU milliseconds that this machine takes, right now, for a fixed amount of work of the kind
// that LiDAR odometry does: sorting 200,000 points by voxel, 20,000 searches for five nearest
// neighbours in a hash grid, as many eigenvalues of 3x3 matrices. One thread; median of five runs,
// half a second in all. A cost divided by this is in cal: machines, and moments on one machine,
// differ by more than programs do, the ratio much less. The work must never change, or figures
// from before and after do not compare.
double CalibrationMs();

}  // namespace isthmus::bench
