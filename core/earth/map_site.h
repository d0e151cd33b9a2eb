// The place of a map on the Earth.
#pragma once

#include <absl/status/statusor.h>

#include <vector>

#include "core/earth/site.h"
#include "core/records/map_graph.h"
#include "core/records/map_info.h"

namespace isthmus::earth {

// FailedPrecondition where there is no datum, or where it says nothing of the map: it is that of
// the anchors' frame, and no anchor holds the map. Without any anchors it is that of the largest.
// NotFound if there is no such map.
absl::StatusOr<Site> SiteOf(const MapInfo& info, const std::vector<RobotAnchor>& anchors,
                            const MapName& map);

}  // namespace isthmus::earth
