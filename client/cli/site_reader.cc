#include "client/cli/site_reader.h"

#include <absl/strings/str_format.h>

#include <algorithm>

namespace isthmus::cli {
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

absl::StatusOr<std::optional<georeference::Site>> ReadSite(client::Client& client,
                                                           uint32_t component) {
  const auto info = client.GetMapInfo();
  if (!info.ok()) return info.status();
  if (!info->datum) return std::optional<georeference::Site>();
  const auto anchors = client.ListAnchors();
  if (!anchors.ok()) return anchors.status();
  if (!IsInSiteFrame(*info, *anchors, component)) {
    absl::FPrintF(stderr,
                  "isthmus: no anchor holds component %d, so the datum says nothing of it: "
                  "written in its own frame\n",
                  component);
    return std::optional<georeference::Site>();
  }
  auto site = georeference::Site::Create(*info->datum);
  if (!site.ok()) return site.status();
  return *std::move(site);
}

absl::StatusOr<georeference::Site> NeedSite(client::Client& client) {
  const auto info = client.GetMapInfo();
  if (!info.ok()) return info.status();
  if (info->datum) return georeference::Site::Create(*info->datum);
  return absl::FailedPreconditionError(
      "the map has no datum: say where its origin lies with `isthmus datum set`");
}

}  // namespace isthmus::cli
