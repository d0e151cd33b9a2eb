// Advice to a person whose server did not answer.
#pragma once

#include <string>

#include "client/library/options.h"

namespace isthmus::client {

// Advice from gRPC's text on the last attempt: no server, or the two do not agree about TLS.
std::string AdviceOnUnreachable(const ClientOptions& options, const std::string& said);

}  // namespace isthmus::client
