// Tokens as messages, and back.
#pragma once

#include <absl/status/statusor.h>

#include "core/records/access_token.h"
#include "isthmus/v1/access_service.pb.h"

namespace isthmus::convert {

v1::Token ToMessage(const AccessToken& token);

// InvalidArgument without a role.
absl::StatusOr<AccessToken> FromMessage(const v1::Token& token);

}  // namespace isthmus::convert
