#include "core/odometry_mode.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <array>
#include <span>

#include "core/paper.h"

namespace isthmus {
namespace {

constexpr std::array kModes = {OdometryMode::kContinuous, OdometryMode::kFloam,
                               OdometryMode::kAloam};
// The last one is there to compare with.
constexpr std::span kModesBuilt(kModes.data(), kHasPaper ? kModes.size() : kModes.size() - 1);

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

std::optional<OdometryMode> FindOdometryMode(const std::string& name) {
  for (const OdometryMode mode : kModes) {
    if (name == ToString(mode)) return mode;
  }
  return std::nullopt;
}

absl::StatusOr<OdometryMode> ParseOdometryMode(const std::string& name) {
  for (const OdometryMode mode : kModesBuilt) {
    if (name == ToString(mode)) return mode;
  }
  const bool left_out = name == ToString(OdometryMode::kAloam);
  return absl::InvalidArgumentError(absl::StrCat(
      left_out ? "this program was built without (ISTHMUS_PAPER=OFF)" : "unknown", " odometry \"",
      name, "\"; known are ", absl::StrJoin(OdometryModeNames(), ", ")));
}

std::vector<std::string> OdometryModeNames() {
  std::vector<std::string> names;
  for (const OdometryMode mode : kModesBuilt) names.emplace_back(ToString(mode));
  return names;
}

}  // namespace isthmus
