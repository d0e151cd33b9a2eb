// The motion between two scans by their poles, from no idea of it.
#pragma once

#include <vector>

#include "core/pose.h"
#include "floam/scan/features.h"

namespace isthmus::floam {

// Motions on the level (T_before_now, sensor frames, as far as a vehicle comes in that time) by
// which the poles of one scan come to stand where those of an earlier one do, best first; none
// where there are too few poles. Both scans are taken as measured, as if in an instant. Takes some
// ms for a period of 0.1 s, a few hundred for seconds.
std::vector<Pose> MotionsOfPoles(const std::vector<TimedPoint>& before,
                                 const std::vector<TimedPoint>& now, double elapsed_s);

}  // namespace isthmus::floam
