// Things at a server that wait for a person, and what that person can do.
#pragma once

#include <string>
#include <vector>

#include "client/report/server_state.h"

namespace isthmus::report {

struct Advice {
  std::string what, todo;
};

// The most urgent first; empty where nothing waits: storage, lost robots, maps that are not joined
// yet, with the reason of their best match, quotas, archives, work that goes on.
std::vector<Advice> WhatIsWaiting(const ServerState& state);

// Advice on a match that is not accepted, by docs/concepts.md, "Reasons".
const char* WhatToDo(MatchReason reason);

}  // namespace isthmus::report
