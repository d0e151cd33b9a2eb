#include "floam/odometry_mode.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <array>

namespace isthmus::floam {
namespace {

constexpr std::array kModes = {OdometryMode::kContinuous, OdometryMode::kFloam,
                               OdometryMode::kAloam};

}  // namespace

absl::StatusOr<OdometryMode> FindOdometryMode(const std::string& name) {
  if (name.empty()) return OdometryMode::kContinuous;
  for (const OdometryMode mode : kModes) {
    if (name == Name(mode)) return mode;
  }
  return absl::InvalidArgumentError(absl::StrCat("unknown odometry \"", name, "\"; known are ",
                                                 absl::StrJoin(OdometryModeNames(), ", ")));
}

const char* Name(OdometryMode mode) {
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

std::vector<std::string> OdometryModeNames() {
  std::vector<std::string> names;
  for (const OdometryMode mode : kModes) names.emplace_back(Name(mode));
  return names;
}

}  // namespace isthmus::floam
