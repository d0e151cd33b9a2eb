// The site's datum as the server has it, where it holds for a map.
#pragma once

#include <absl/status/statusor.h>

#include <optional>

#include "client/library/client.h"
#include "core/earth/site.h"

namespace isthmus::cli {

// The site in whose frame the map lies; see earth::SiteOf.
absl::StatusOr<earth::Site> ReadSite(client::Client& client, const MapName& map);
// Absent where the datum says nothing of the map, and says so on stderr where there is one.
absl::StatusOr<std::optional<earth::Site>> ReadSiteIfKnown(client::Client& client,
                                                           const MapName& map);

// The site of the anchors' frame; FailedPrecondition, saying how to set it, where there is no
// datum.
absl::StatusOr<earth::Site> ReadAnchorsSite(client::Client& client);

}  // namespace isthmus::cli
