// Tables of a server's robots, matches, loops, revisions and times.
#pragma once

#include "client/report/server_state.h"
#include "client/report/table.h"

namespace isthmus::report {

// Cut after kMostRows rows, which the note then says.
Table RobotsTable(const ServerState& state);     // Every session: tracking, size, place.
Table MatchesTable(const ServerState& state);    // Matches that carry the map first.
Table DecisionsTable(const ServerState& state);  // By hand, with their notes.
Table LoopsTable(const ServerState& state);
Table RevisionsTable(const ServerState& state);  // The newest first.
Table TimesTable(const ServerState& state);      // Wall times, ms.

}  // namespace isthmus::report
