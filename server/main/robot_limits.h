// Limits of robots by name, as one line of text.
#pragma once

#include <absl/status/statusor.h>

#include <map>
#include <string>

#include "core/ids.h"
#include "server/retention_options.h"

namespace isthmus::server {

// Days that a limit on age may have, which is a second at least: a number next to 0 would let
// sessions go as soon as they are finished.
inline constexpr double kLeastAgeDays = 0.00001, kMostAgeDays = 36'500;

// Entries "NAME=QUOTA_BYTES" or "NAME=QUOTA_BYTES:MAX_AGE_DAYS", separated by spaces; 0 stands for
// no limit, as does an age that is left out. InvalidArgument, saying what is expected.
absl::StatusOr<std::map<RobotId, RetentionLimits>> ParseRobotLimits(const std::string& text);

// ParseRobotLimits reads it back to the same.
std::string PrintRobotLimits(const std::map<RobotId, RetentionLimits>& limits);

}  // namespace isthmus::server
