#include "client/console/region_reader.h"

#include <absl/strings/str_cat.h>

#include "client/console/console.h"
#include "client/console/say.h"

namespace isthmus::cli {
namespace {

// A map may have grown by so many while it is read, and to the double. A guess: two minutes of ten
// robots.
constexpr uint64_t kNewPoints = 10'000'000;

}  // namespace

void SayWhichMap(client::Client& client, const MapName& map) {
  if (!map.session().empty()) return;
  const auto info = client.GetMapInfo();
  if (!info.ok() || info->components.size() < 2) return;
  for (const Component& component : info->components) {
    if (component.component != map.number()) continue;
    Warn("isthmus: map %d is that of %s, one of %d: --map SESSION names one\n", component.component,
         component.reference.value(), info->components.size());
  }
}

absl::StatusOr<RegionChunk> ReadRegion(client::Client& client, const RegionQuery& query) {
  // A server that says less of its map than it sends would fill the memory.
  const auto info = client.GetMapInfo();
  if (!info.ok()) return info.status();
  uint64_t most = kNewPoints;
  for (const Component& component : info->components) most += 2 * component.point_count;
  RegionChunk all;
  Progress progress("points", 0);
  const absl::Status status = client.QueryRegion(query, [&](const RegionChunk& chunk) {
    all.revision = chunk.revision;
    all.robots = chunk.robots;
    all.resolution_m = chunk.resolution_m;
    all.points.insert(all.points.end(), chunk.points.begin(), chunk.points.end());
    progress.Update(all.points.size());
    return all.points.size() <= most;
  });
  if (all.points.size() > most) {
    return absl::ResourceExhaustedError(
        absl::StrCat("the server sends more than ", most, " points, and says that the map has ",
                     (most - kNewPoints) / 2, ": ask again, or ask for a box of it"));
  }
  if (!status.ok()) return status;
  return all;
}

}  // namespace isthmus::cli
