#include "server/access/caller.h"

#include <algorithm>

namespace isthmus::access {

bool Matches(absl::string_view pattern, absl::string_view name) {
  // The last star takes one character more whenever the rest does not fit.
  size_t at = 0, read = 0, after_star = absl::string_view::npos, taken = 0;
  while (read < name.size()) {
    if (at < pattern.size() && pattern[at] == '*') {
      after_star = ++at;
      taken = read;
    } else if (at < pattern.size() && pattern[at] == name[read]) {
      ++at;
      ++read;
    } else if (after_star != absl::string_view::npos) {
      at = after_star;
      read = ++taken;
    } else {
      return false;
    }
  }
  while (at < pattern.size() && pattern[at] == '*') ++at;
  return at == pattern.size();
}

bool Caller::MayFeed(const RobotId& robot) const {
  return role == Role::kAdmin ||
         std::any_of(robots.begin(), robots.end(),
                     [&](const std::string& own) { return Matches(own, robot.value()); });
}

RobotId Caller::OnlyRobot() const {
  const bool is_one =
      role != Role::kAdmin && robots.size() == 1 && robots.front().find('*') == std::string::npos;
  return is_one ? RobotId(robots.front()) : RobotId();
}

bool Caller::MaySee(absl::string_view site) const {
  return std::any_of(sites.begin(), sites.end(),
                     [&](const std::string& own) { return Matches(own, site); });
}

}  // namespace isthmus::access
