// The ways of estimating a robot's motion.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

namespace isthmus::floam {

enum class OdometryMode {
  kContinuous,  // Pose and in-scan motion estimated together; the default.
  kFloam,       // The paper's two stages of distortion compensation.
  kAloam,       // Scan to scan, then scan to map: A-LOAM, to compare with.
};

// "continuous", "floam" and, unless it was left out (core/paper.h), "aloam"; the empty name is the
// default. InvalidArgument, with the known names in the message, for any other.
absl::StatusOr<OdometryMode> FindOdometryMode(const std::string& name);
const char* Name(OdometryMode mode);
std::vector<std::string> OdometryModeNames();

}  // namespace isthmus::floam
