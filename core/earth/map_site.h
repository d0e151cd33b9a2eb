// The place of a component of the map on the Earth.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <vector>

#include "core/earth/site.h"
#include "core/records/map_graph.h"
#include "core/records/map_info.h"

namespace isthmus::earth {

// FailedPrecondition where there is no datum, or where it says nothing of the component: it is that
// of the anchors' frame, and no anchor holds the component. Where there are no anchors at all it is
// that of the largest.
absl::StatusOr<Site> SiteOf(const MapInfo& info, const std::vector<RobotAnchor>& anchors,
                            uint32_t component);

}  // namespace isthmus::earth
