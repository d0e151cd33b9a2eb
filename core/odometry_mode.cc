#include "core/odometry_mode.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <array>

namespace isthmus {
namespace {

constexpr std::array kModes = {OdometryMode::kContinuous, OdometryMode::kFloam,
                               OdometryMode::kAloam};

}  // namespace

const char* ToString(OdometryMode mode) {
  switch (mode) {
    case OdometryMode::kContinuous:
      return "continuous";
    case OdometryMode::kFloam:
      return "floam";
    case OdometryMode::kAloam:
      return "aloam";
  }
  return "unknown";
}

absl::StatusOr<OdometryMode> ParseOdometryMode(const std::string& name) {
  for (const OdometryMode mode : kModes) {
    if (name == ToString(mode)) return mode;
  }
  return absl::InvalidArgumentError(absl::StrCat("unknown odometry \"", name, "\"; known are ",
                                                 absl::StrJoin(OdometryModeNames(), ", ")));
}

std::vector<std::string> OdometryModeNames() {
  std::vector<std::string> names;
  for (const OdometryMode mode : kModes) names.emplace_back(ToString(mode));
  return names;
}

}  // namespace isthmus
