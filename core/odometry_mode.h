// The ways of estimating a robot's motion.
#pragma once

#include <absl/status/statusor.h>

#include <optional>
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
// The mode of that name, built or not; absent for any other name.
std::optional<OdometryMode> FindOdometryMode(const std::string& name);
// The mode of that name among the built ones (core/paper.h). InvalidArgument, with the known names
// in the message, for any other name.
absl::StatusOr<OdometryMode> ParseOdometryMode(const std::string& name);
std::vector<std::string> OdometryModeNames();

}  // namespace isthmus
