// The ways of estimating a robot's motion.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

namespace isthmus {

enum class OdometryMode {
  kContinuous,  // Pose and in-scan motion estimated together; the default.
  kFloam,       // The paper's two stages of distortion compensation.
  kAloam,       // Scan to scan, then scan to map: A-LOAM, to compare with.
};

// Stable lower-case name ("continuous"); used in settings, storage and JSON.
const char* ToString(OdometryMode mode);
// Of those that were built (core/paper.h). InvalidArgument, with the known names in the message,
// for any other name.
absl::StatusOr<OdometryMode> ParseOdometryMode(const std::string& name);
std::vector<std::string> OdometryModeNames();

}  // namespace isthmus
