// The tokens of a server as text: one line each, with a checksum behind them.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "core/records/access_token.h"

namespace isthmus::access {

// A token as it is kept.
struct StoredToken {
  AccessToken token;
  std::string hash;  // SHA-256 of its secret: 32 bytes.
};

// "robot", "reader", "operator", "admin".
std::string RoleName(AccessRole role);
// InvalidArgument, naming those there are.
absl::StatusOr<AccessRole> ParseRole(const std::string& name);

// InvalidArgument, saying what is expected, for a name, a pattern or a number of them that cannot
// be kept, a robot's token without robots, and an administrator's with some.
absl::Status CheckToken(const AccessToken& token);

// Stamps are kept to the second.
std::string PrintTokens(const std::vector<StoredToken>& tokens);
// DataLoss where a byte of it is not as PrintTokens wrote it, FailedPrecondition where a newer
// program wrote it.
absl::StatusOr<std::vector<StoredToken>> ParseTokens(const std::string& text);
// The last line, of all above it.
std::string SumLine(const std::string& text);

}  // namespace isthmus::access
