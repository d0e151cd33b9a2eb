// The events of the server itself, in the event logs of all its sites.
#pragma once

#include <string>
#include <vector>

#include "core/records/event.h"
#include "server/main/open_map.h"

namespace isthmus::server {

void LogToAllSites(const std::vector<OpenMap>& maps, EventKind kind, const std::string& text);

// Also says whether the server before this one could say that it stopped.
void NoteStart(const std::vector<OpenMap>& maps, const std::string& version);

}  // namespace isthmus::server
