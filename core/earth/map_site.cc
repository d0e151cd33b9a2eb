#include "core/earth/map_site.h"

#include <absl/strings/str_cat.h>

#include <algorithm>

namespace isthmus::earth {
namespace {

bool IsInSiteFrame(const MapInfo& info, const std::vector<RobotAnchor>& anchors,
                   uint32_t component) {
  if (anchors.empty()) return component == 0;
  if (component >= info.components.size()) return false;
  const auto& sessions = info.components[component].sessions;
  return std::any_of(anchors.begin(), anchors.end(), [&](const RobotAnchor& any) {
    return std::count(sessions.begin(), sessions.end(), any.anchor.submap.session) > 0;
  });
}

}  // namespace

absl::StatusOr<Site> SiteOf(const MapInfo& info, const std::vector<RobotAnchor>& anchors,
                            const MapName& map) {
  if (!info.datum) {
    return absl::FailedPreconditionError(
        "the map has no datum: say where its origin lies with `isthmus datum set`");
  }
  const auto number = NumberIn(info, map);
  if (!number.ok()) return number.status();
  if (!IsInSiteFrame(info, anchors, *number)) {
    return absl::FailedPreconditionError(
        absl::StrCat("no anchor holds map ", map.ToText(), ", so the datum says nothing of it"));
  }
  return Site::Create(*info.datum);
}

}  // namespace isthmus::earth
