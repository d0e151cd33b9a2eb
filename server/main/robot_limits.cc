#include "server/main/robot_limits.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <charconv>
#include <vector>

namespace isthmus::server {
namespace {

bool ParseEntry(const std::string& entry, RobotId* robot, RetentionLimits* limits) {
  const std::vector<std::string> sides = absl::StrSplit(entry, '=');
  if (sides.size() != 2 || sides[0].empty()) return false;
  const std::vector<std::string> numbers = absl::StrSplit(sides[1], ':');
  if (numbers.size() > 2 || !absl::SimpleAtoi(numbers[0], &limits->quota_bytes)) return false;
  *robot = RobotId(sides[0]);
  if (numbers.size() == 1) return true;
  // Written so that NaN fails too.
  double& days = limits->max_age_days;
  return absl::SimpleAtod(numbers[1], &days) &&
         (days == 0 || (days >= kLeastAgeDays && days <= kMostAgeDays));
}

}  // namespace

absl::StatusOr<std::map<RobotId, RetentionLimits>> ParseRobotLimits(const std::string& text) {
  std::map<RobotId, RetentionLimits> robots;
  const std::vector<std::string> entries = absl::StrSplit(text, ' ', absl::SkipEmpty());
  for (const std::string& entry : entries) {
    RobotId robot;
    RetentionLimits limits;
    if (!ParseEntry(entry, &robot, &limits)) {
      return absl::InvalidArgumentError(
          absl::StrCat("\"", entry,
                       "\" is not NAME=QUOTA_BYTES or NAME=QUOTA_BYTES:MAX_AGE_DAYS; give such "
                       "entries separated by spaces, or \"\""));
    }
    if (!robots.emplace(robot, limits).second) {
      return absl::InvalidArgumentError(absl::StrCat(robot.value(), " is given twice"));
    }
  }
  return robots;
}

std::string PrintRobotLimits(const std::map<RobotId, RetentionLimits>& limits) {
  std::string text;
  for (const auto& [robot, limit] : limits) {
    char days[64];
    const auto end = std::to_chars(days, days + sizeof(days), limit.max_age_days).ptr;
    absl::StrAppend(&text, text.empty() ? "" : " ", robot.value(), "=", limit.quota_bytes, ":",
                    std::string(days, end));
  }
  return text;
}

}  // namespace isthmus::server
