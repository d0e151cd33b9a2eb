// Changes of the map since a time or a revision.
#include <absl/strings/str_cat.h>
#include <absl/time/time.h>

#include <algorithm>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/records/region_of.h"
#include "server/composition/changes/changed_points.h"
#include "server/composition/changes/volumes.h"
#include "server/pipeline/view_reader.h"

namespace isthmus::server {
namespace {

using composition::ComparedSubmap;

// Submaps during which the time passed are of neither side.
std::vector<ComparedSubmap> SidesOf(std::vector<PlacedSubmap> placed, int64_t since_ns) {
  std::vector<ComparedSubmap> sides;
  for (PlacedSubmap& submap : placed) {
    const bool is_before = submap.submap->last_stamp_ns < since_ns;
    if (is_before || submap.submap->first_stamp_ns >= since_ns) {
      sides.push_back({std::move(submap), !is_before});
    }
  }
  return sides;
}

// By which submaps came into the map, though they may have gone and come again.
std::vector<ComparedSubmap> SidesOf(
    std::vector<PlacedSubmap> placed,
    const std::vector<std::pair<int64_t, SubmapMove>>& moves_since) {
  std::set<SubmapId> moved, came;
  for (const auto& [revision, move] : moves_since) {
    if (moved.insert(move.submap).second && !move.before) came.insert(move.submap);
  }
  std::vector<ComparedSubmap> sides;
  for (PlacedSubmap& submap : placed) {
    const bool is_after = came.contains(submap.submap->id);
    sides.push_back({std::move(submap), is_after});
  }
  return sides;
}

std::string TimesOf(const std::vector<PlacedSubmap>& submaps) {
  int64_t first = std::numeric_limits<int64_t>::max(), last = 0;
  for (const PlacedSubmap& placed : submaps) {
    first = std::min(first, placed.submap->first_stamp_ns);
    last = std::max(last, placed.submap->last_stamp_ns);
  }
  const auto text = [](int64_t ns) {
    return absl::FormatTime("%Y-%m-%dT%H:%M:%SZ", absl::FromUnixNanos(ns), absl::UTCTimeZone());
  };
  return absl::StrCat("it was scanned from ", text(first), " to ", text(last));
}

}  // namespace

absl::StatusOr<ChangeList> ViewReader::FindChanges(const ChangeQuery& query,
                                                   const std::function<bool()>& keep_on) const {
  const MapWriter::View view = map_->view();
  const auto number = view->NumberOf(query.component);
  if (!number.ok()) return number.status();
  std::vector<PlacedSubmap> placed = view->PlacedSubmaps();
  std::erase_if(placed, [&](const PlacedSubmap& submap) {
    return submap.submap == nullptr || submap.component != *number;
  });
  if (placed.empty()) {
    return absl::NotFoundError(absl::StrCat("nothing lies in map ", query.component.ToText()));
  }
  ChangeList list;
  list.revision = view->revision->revision;
  const std::string times = TimesOf(placed);
  std::vector<ComparedSubmap> sides;
  if (query.since_revision) {
    if (*query.since_revision > list.revision) {
      return absl::NotFoundError(absl::StrCat("there is no revision ", *query.since_revision,
                                              " yet: the latest is ", list.revision));
    }
    const auto moves = store_->ListMoves(*query.since_revision, list.revision);
    if (!moves.ok()) return moves.status();
    sides = SidesOf(std::move(placed), *moves);
  } else {
    sides = SidesOf(std::move(placed), query.since_ns.value_or(0));
  }
  for (const ComparedSubmap& submap : sides) {
    ++(submap.is_after ? list.submaps_after : list.submaps_before);
  }
  if (list.submaps_before == 0 || list.submaps_after == 0) {
    return absl::FailedPreconditionError(
        absl::StrCat("nothing in map ", query.component.ToText(), " is from ",
                     list.submaps_before == 0 ? "before that: " : "after that: ", times));
  }
  const SubmapReader read = [this](const SubmapId& id) { return submaps_->GetOrThrow(id); };
  const auto points =
      composition::FindChangedPoints(sides, read, RegionOf(query, *number), keep_on);
  if (!points.ok()) return points.status();
  list.volumes = composition::MakeVolumes(
      *points, sides, {.smallest_m = query.smallest_m, .wants_points = query.wants_points});
  if (list.volumes.size() > query.max_volumes) {
    list.left_out = list.volumes.size() - query.max_volumes;
    list.volumes.resize(query.max_volumes);
  }
  return list;
}

}  // namespace isthmus::server
