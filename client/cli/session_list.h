// Sessions as `robots` and `session list` print them.
#pragma once

#include <optional>
#include <vector>

#include "core/records/server_load.h"
#include "core/records/session_status.h"

namespace isthmus::cli {

// A table, or a JSON document, to stdout; below it, of `load`, the robots that are localised.
void PrintSessions(const std::vector<SessionStatus>& sessions, bool as_json,
                   const std::optional<ServerLoad>& load = {});

}  // namespace isthmus::cli
