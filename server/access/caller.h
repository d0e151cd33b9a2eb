// The caller of a method, and the rights that its token gives.
#pragma once

#include <absl/strings/string_view.h>

#include <string>
#include <vector>

#include "core/ids.h"
#include "core/records/access_token.h"

namespace isthmus::access {

using Role = AccessRole;

// True if `name` fits the pattern, in which each `*` stands for any characters, none included. For
// two patterns: true only if all that `name` stands for is in the pattern too.
bool Matches(absl::string_view pattern, absl::string_view name);

// A caller without a token, on a server that asks for none, may do everything: the default.
struct Caller {
  std::string token = {};  // The name of its token, not its secret; empty: it needed none.
  Role role = Role::kAdmin;
  std::vector<std::string> robots = {"*"};  // Names and patterns of robots it may feed.
  std::vector<std::string> sites = {"*"};   // Names and patterns of sites it may see, in any role.

  // True if it may send data for that robot, and learn of its sessions in order to do so.
  bool MayFeed(const RobotId& robot) const;
  // The one robot that the token is for; empty where it may be another's.
  RobotId OnlyRobot() const;
  bool MaySee(absl::string_view site) const;
};

}  // namespace isthmus::access
