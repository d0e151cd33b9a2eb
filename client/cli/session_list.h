// Sessions as `robots` and `session list` print them.
#pragma once

#include <vector>

#include "core/records/session_status.h"

namespace isthmus::cli {

// A table, or a JSON document, to stdout.
void PrintSessions(const std::vector<SessionStatus>& sessions, bool as_json);

}  // namespace isthmus::cli
