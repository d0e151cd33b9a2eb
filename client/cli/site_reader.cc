#include "client/cli/site_reader.h"

#include "client/console/say.h"
#include "core/earth/map_site.h"

namespace isthmus::cli {
namespace {

absl::StatusOr<earth::Site> SiteOf(const MapInfo& info, client::Client& client,
                                   const MapName& map) {
  const auto anchors = client.ListAnchors();
  if (!anchors.ok()) return anchors.status();
  return earth::SiteOf(info, *anchors, map);
}

}  // namespace

absl::StatusOr<earth::Site> ReadSite(client::Client& client, const MapName& map) {
  const auto info = client.GetMapInfo();
  if (!info.ok()) return info.status();
  return SiteOf(*info, client, map);
}

absl::StatusOr<std::optional<earth::Site>> ReadSiteIfKnown(client::Client& client,
                                                           const MapName& map) {
  const auto info = client.GetMapInfo();
  if (!info.ok()) return info.status();
  if (!info->datum) return std::optional<earth::Site>();
  auto site = SiteOf(*info, client, map);
  if (site.ok()) return *std::move(site);
  if (!absl::IsFailedPrecondition(site.status())) return site.status();
  Warn("isthmus: %s: written in the map's own frame\n", site.status().message());
  return std::optional<earth::Site>();
}

absl::StatusOr<earth::Site> ReadAnchorsSite(client::Client& client) {
  const auto info = client.GetMapInfo();
  if (!info.ok()) return info.status();
  return earth::SiteOf(*info, {}, 0);
}

}  // namespace isthmus::cli
