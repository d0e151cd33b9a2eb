#include "client/library/map_mirror.h"

#include <algorithm>
#include <utility>

namespace isthmus::client {

void MapMirror::Note(const MapStep& step) {
  if (step.restart) {
    for (const auto& [id, version] : told_) differing_.insert(id);
    told_.clear();
    submaps_.clear();
  }
  for (const TileId& id : step.removed_tiles) {
    told_.erase(id);
    differing_.insert(id);
  }
  for (const TileInfo& tile : step.tiles) {
    told_[tile.id] = tile.version;
    differing_.insert(tile.id);
  }
  for (const SubmapPlace& place : step.submaps) {
    if (place.component) {
      submaps_[place.submap] = place;
    } else {
      submaps_.erase(place.submap);
    }
  }
  if (step.robots) robots_ = *step.robots;
  mark_ = step.mark;
}

absl::Status MapMirror::Fetch(const TileId& id, uint64_t version,
                              const std::map<uint64_t, std::shared_ptr<const Tile>>& known) {
  if (const auto same = known.find(version); same != known.end()) {
    held_[id] = same->second;
    return absl::OkStatus();
  }
  absl::StatusOr<MapTile> got = client_.GetTile(id);
  // Gone from the server's newest map: of that another step tells.
  if (absl::IsNotFound(got.status())) return absl::OkStatus();
  if (!got.ok()) return got.status();
  ++tiles_fetched_;
  // Perhaps a newer one than was told of; so is that another step's.
  held_[id] = std::make_shared<const Tile>(
      Tile{got->info.version, std::move(got->robots), std::move(got->points)});
  return absl::OkStatus();
}

absl::Status MapMirror::Take(const MapStep& step) {
  Note(step);
  // Tiles that go under one name may come under another.
  std::map<uint64_t, std::shared_ptr<const Tile>> known;
  for (const TileId& id : differing_) {
    const auto held = held_.find(id);
    if (held == held_.end()) continue;
    known[held->second->version] = held->second;
    if (!told_.contains(id)) held_.erase(held);
  }
  for (auto it = differing_.begin(); it != differing_.end();) {
    const auto told = told_.find(*it);
    const auto is_as_told = [&] {
      const auto held = held_.find(*it);
      if (told == told_.end()) return held == held_.end();
      return held != held_.end() && held->second->version == told->second;
    };
    if (!is_as_told()) {
      absl::Status status = Fetch(*it, told->second, known);
      if (!status.ok()) return status;
    }
    it = is_as_told() ? differing_.erase(it) : std::next(it);
  }
  return absl::OkStatus();
}

absl::Status MapMirror::Follow(const AtMap& at_map) {
  absl::Status failure;
  const absl::Status status = client_.WatchMap(mark_, level_, [&](const MapStep& step) {
    failure = Take(step);
    if (!failure.ok()) return false;
    return !differing_.empty() || at_map(*this);
  });
  return failure.ok() ? status : failure;
}

RegionChunk MapMirror::Points(uint32_t component) const {
  RegionChunk all;
  all.revision = mark_.revision;
  std::set<RobotId> robots;
  const auto begin = held_.lower_bound({component, 0, INT32_MIN, INT32_MIN});
  const auto end = held_.lower_bound({component + 1, 0, INT32_MIN, INT32_MIN});
  for (auto it = begin; it != end; ++it) {
    robots.insert(it->second->robots.begin(), it->second->robots.end());
  }
  all.robots.assign(robots.begin(), robots.end());
  for (auto it = begin; it != end; ++it) {
    std::vector<uint32_t> names;
    for (const RobotId& robot : it->second->robots) {
      const auto place = std::lower_bound(all.robots.begin(), all.robots.end(), robot);
      names.push_back(static_cast<uint32_t>(place - all.robots.begin()));
    }
    for (MapPoint point : it->second->points) {
      point.robot = point.robot < names.size() ? names[point.robot] : 0;
      all.points.push_back(point);
    }
  }
  return all;
}

}  // namespace isthmus::client
