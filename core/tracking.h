// Trust in the pose of a scan: the tracking state of an odometry.
#pragma once

namespace isthmus {

enum class Tracking {
  kUnknown,     // No scan yet, or none that says.
  kOk,          // Matched, and every direction is observed.
  kDegenerate,  // Some directions are not observed; the prediction was kept along them.
  kLost,        // Not matched: a prediction only.
};

// Stable lower-case name ("ok"), for people and JSON; empty for kUnknown.
const char* ToString(Tracking tracking);

}  // namespace isthmus
