// A token as it is told of: whose it is and what it lets do. Never the secret itself.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace isthmus {

// The purpose of a token.
enum class AccessRole {
  kRobot,     // Feeds the sessions of its own robots, and is localised.
  kReader,    // Reads the map.
  kOperator,  // Reads it, and changes it by hand.
  kAdmin,     // Everything; makes tokens and backups.
};

struct AccessToken {
  std::string name = {};
  AccessRole role = AccessRole::kReader;
  std::vector<std::string> robots = {};  // Robots it may feed; names, and patterns with `*`.
  std::vector<std::string> sites = {};   // Sites it may use, in any role; as `robots`.
  int64_t created_ns = 0;
  int64_t expires_ns = 0;  // 0: never.
  int64_t revoked_ns = 0;  // 0: it was not.

  friend bool operator==(const AccessToken&, const AccessToken&) = default;
};

// A token that was just made. The secret is shown this once.
struct NewAccessToken {
  AccessToken token;
  std::string secret;
};

}  // namespace isthmus
