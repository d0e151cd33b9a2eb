// Advice to a person whose server did not answer.
#pragma once

#include <string>

#include "client/library/options.h"

namespace isthmus::client {

// What to look at, from what gRPC says of the last attempt: whether there is a server, or the two
// do not agree about TLS.
std::string AdviceOnUnreachable(const ClientOptions& options, const std::string& said);

}  // namespace isthmus::client
