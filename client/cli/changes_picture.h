// Changes of the map, drawn on it as seen from above.
#pragma once

#include <string>

#include "client/library/client.h"

namespace isthmus::cli {

// A PNG of what the map has in that region, with outlines of what came (green) and what went (red);
// "-" is standard output. Errors as Client::QueryRegion; FailedPrecondition where the map has no
// points there.
absl::Status DrawChanges(client::Client& client, const RegionQuery& region,
                         const ChangeList& changes, const std::string& path);

}  // namespace isthmus::cli
