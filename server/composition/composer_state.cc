#include "server/composition/composer_state.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "server/composition/limits.h"
#include "server/composition/submap_labels.h"
#include "server/composition/tiles/points_by_tile.h"

namespace isthmus::composition {
namespace {

double InRange(double value, double lowest, double highest, double otherwise) {
  return std::isfinite(value) ? std::clamp(value, lowest, highest) : otherwise;
}

ComposerOptions Sane(const ComposerOptions& given) {
  const ComposerOptions defaults;
  ComposerOptions options;
  options.voxel_m = InRange(given.voxel_m, 0.001, 100, defaults.voxel_m);
  options.tile_m = InRange(given.tile_m, options.voxel_m, 1e5, defaults.tile_m);
  options.min_move_m = InRange(given.min_move_m, 0, 1e5, defaults.min_move_m);
  options.max_tiles = std::max(given.max_tiles, kSubmapTilesParts);
  options.cache_bytes = given.cache_bytes;
  options.drop_gone = given.drop_gone;
  return options;
}

}  // namespace

Composer::State::State(const ComposerOptions& given, std::shared_ptr<MapFile> map_file)
    : options(Sane(given)),
      grid(options.voxel_m),
      layout(options.tile_m, options.voxel_m),
      file(std::move(map_file)),
      thinned(file, options.cache_bytes / kThinnedParts -
                        (options.drop_gone ? options.cache_bytes / kViewsParts : 0)),
      cache(std::make_shared<TileCache>(file,
                                        options.cache_bytes - options.cache_bytes / kThinnedParts)),
      builder(grid, &tile_thinner),
      made_tiles(std::make_shared<MadeTiles>(kPyramidBytes)),
      limit(static_cast<size_t>(options.max_tiles)) {
  if (options.drop_gone) {
    visibility_filter.emplace(options.min_move_m, options.cache_bytes / kViewsParts);
  }
}

absl::StatusOr<std::shared_ptr<const ComposedMap>> Composer::State::Compose(
    int64_t revision, const std::vector<PlacedSubmap>& given, const SubmapReader& reader,
    const Progress& keeps_on, uint64_t waiting) {
  std::vector<PlacedSubmap> placed;
  placed.reserve(given.size());
  for (const PlacedSubmap& p : given) {
    const bool usable = p.submap && p.T_map_submap.IsFinite();
    if (usable) placed.push_back(p);
  }

  at_hand.reset();
  last_tiles_remade = 0;
  progress = keeps_on;
  share = 0;
  const std::map<uint32_t, uint32_t> frames = FramesOf(placed);
  absl::Status status = KeepToMemory();  // Left to do if an earlier call failed.
  if (status.ok()) status = PlaceAll(placed, frames, reader);
  if (!status.ok()) return status;
  DropUnwanted();
  if (status = LookThrough(reader); !status.ok()) return status;
  MarkLost();
  KeepToLimit();
  if (status = RemakeTiles(revision); !status.ok()) return status;
  left_out = CountLeftOut();
  TiledMap::Submaps about{.missing = missing, .waiting = waiting};
  for (const PlacedSubmap& p : placed) about.places.emplace(p.submap->id.session, p.component);
  return MapOf(revision, frames, std::move(about));
}

// A component's frame is the one that its first known submap had, so that tiles stay good when
// components are only renumbered.
std::map<uint32_t, uint32_t> Composer::State::FramesOf(const std::vector<PlacedSubmap>& placed) {
  std::map<uint32_t, std::pair<SubmapId, uint32_t>> first_known;  // Component: its submap, frame.
  std::map<uint32_t, uint32_t> frames;
  for (const PlacedSubmap& p : placed) {
    frames[p.component] = 0;
    const auto it = submaps.find(p.submap->id);
    if (it == submaps.end()) continue;
    const auto [known, inserted] =
        first_known.try_emplace(p.component, it->first, it->second.frame);
    if (!inserted && it->first < known->second.first) {
      known->second = {it->first, it->second.frame};
    }
  }
  std::set<uint32_t> taken;
  for (auto& [component, frame] : frames) {
    const auto it = first_known.find(component);
    const bool keep = it != first_known.end() && taken.insert(it->second.second).second;
    frame = keep ? it->second.second : next_frame++;
  }
  return frames;
}

uint32_t Composer::State::RobotNumber(const RobotId& robot) {
  const auto [it, inserted] =
      robot_numbers.try_emplace(robot.value(), static_cast<uint32_t>(robots.size()));
  if (inserted) robots.push_back(robot);
  return it->second;
}

// Tiles whose points cannot be read back are made again.
void Composer::State::MarkLost() {
  const std::set<const Tile*> lost = cache->TakeLost();
  if (lost.empty()) return;
  for (const MadeMap* map : {&present, &gone}) {
    for (const auto& [key, tile] : map->tiles) {
      if (lost.contains(tile.get())) dirty.insert(key);
    }
  }
}

void Composer::State::EnterTiles(const Composed& composed) {
  dirty.insert(composed.tiles.begin(), composed.tiles.end());
  for (size_t i = 0; i < composed.tiles.size(); ++i) {
    limit.Add(composed.tiles[i], composed.point_count[i]);
  }
}

void Composer::State::LeaveTiles(const Composed& composed) {
  dirty.insert(composed.tiles.begin(), composed.tiles.end());
  for (size_t i = 0; i < composed.tiles.size(); ++i) {
    limit.Remove(composed.tiles[i], composed.point_count[i]);
  }
}

void Composer::State::ForgetSubmap(const SubmapId& id) {
  const auto it = submaps.find(id);
  if (it == submaps.end()) return;
  LeaveTiles(it->second);
  thinned.Erase(id);
  if (visibility_filter) visibility_filter->Forget(id);
  submaps.erase(it);
}

absl::Status Composer::State::PlaceAll(const std::vector<PlacedSubmap>& placed,
                                       const std::map<uint32_t, uint32_t>& frames,
                                       const SubmapReader& reader) {
  for (auto& [id, composed] : submaps) composed.wanted = false;
  missing = 0;
  size_t done = 0;
  for (const PlacedSubmap& p : placed) {
    at_hand = p.submap->id;
    absl::Status status = PlaceSubmap(p, frames.at(p.component), reader);
    at_hand.reset();
    if (status.ok()) status = thinned.KeepToMemory();
    if (!status.ok()) return status;
    share = kReadingShare * static_cast<double>(++done) / static_cast<double>(placed.size());
    if (!KeepsOn()) return Stopped();
  }
  return absl::OkStatus();
}

bool Composer::State::IsKnown(const PlacedSubmap& placed) const {
  const auto it = submaps.find(placed.submap->id);
  return it != submaps.end() && robots[it->second.robot] == placed.submap->robot &&
         it->second.IsOf(FingerprintOf(*placed.submap));
}

// Brings what is known of one submap up to date; every tile it left, entered or moved on is dirty.
// One that cannot be read is forgotten.
absl::Status Composer::State::PlaceSubmap(const PlacedSubmap& placed, uint32_t frame,
                                          const SubmapReader& reader) {
  const SubmapId& id = placed.submap->id;
  const Pose& T_map_submap = placed.T_map_submap;
  const uint32_t robot = RobotNumber(placed.submap->robot);
  const bool is_known = IsKnown(placed);
  if (!is_known) ForgetSubmap(id);  // One that was called so.
  Composed& composed = submaps[id];
  if (is_known && composed.frame == frame &&
      LargestMove(composed.bounds, composed.T_map_submap, T_map_submap) <= options.min_move_m) {
    composed.wanted = true;
    return absl::OkStatus();
  }
  absl::StatusOr<std::vector<WeightedPoint>> points = PointsOf(placed, is_known, reader, &composed);
  if (!points.ok()) {
    ForgetSubmap(id);
    if (!absl::IsNotFound(points.status())) return points.status();
    ++missing;
    return absl::OkStatus();
  }
  std::optional<PointsByTile> by_tile = SortByTile(
      *points, frame, T_map_submap, grid, layout,
      static_cast<size_t>(options.max_tiles / kSubmapTilesParts), [this] { return KeepsOn(); });
  if (!by_tile) {
    ForgetSubmap(id);
    return Stopped();
  }
  LeaveTiles(composed);
  composed.id = id;
  composed.robot = robot;
  composed.frame = frame;
  composed.T_map_submap = T_map_submap;
  composed.tiles = by_tile->tiles;
  composed.point_count = by_tile->point_count;
  composed.left_out = by_tile->left_out;
  composed.wanted = true;
  EnterTiles(composed);
  if (visibility_filter) visibility_filter->Place(id, frame, T_map_submap, composed.bounds);
  thinned.Put(id, *std::move(points), *std::move(by_tile));
  return absl::OkStatus();
}

// Thinned. NotFound when the reader has not the submap that is meant, Cancelled when told to stop;
// else fails as the file does.
absl::StatusOr<std::vector<WeightedPoint>> Composer::State::PointsOf(const PlacedSubmap& placed,
                                                                     bool is_known,
                                                                     const SubmapReader& reader,
                                                                     Composed* composed) {
  if (is_known) return thinned.TakeOut(placed.submap->id);
  const std::shared_ptr<const Submap> content = reader(placed.submap->id);
  SubmapFingerprint fingerprint = FingerprintOf(*placed.submap);
  // Another one than was meant: the first one's session was deleted meanwhile.
  if (content == nullptr || !CoversTheSame(*content, fingerprint)) {
    return absl::NotFoundError("the submap is not there");
  }
  std::optional<ThinnedSubmap> made =
      Thin(*content, grid, &submap_thinner, [this] { return KeepsOn(); });
  if (!made || !LabelPoints(
                   *content, [this] { return KeepsOn(); }, &made->points)) {
    return Stopped();
  }
  if (fingerprint.content == 0) {
    fingerprint.content = ContentOf(*content);
    found.emplace_back(placed.submap->id, fingerprint.content);
  }
  composed->fingerprint = fingerprint;
  composed->bounds = made->bounds;
  const auto keep_on = [this] { return KeepsOn(); };
  if (visibility_filter && !visibility_filter->JudgeOwn(*content, grid, keep_on, &made->points)) {
    return Stopped();
  }
  return std::move(made->points);
}

void Composer::State::DropUnwanted() {
  std::vector<SubmapId> unwanted;
  for (const auto& [id, composed] : submaps) {
    if (!composed.wanted) unwanted.push_back(id);
  }
  for (const SubmapId& id : unwanted) ForgetSubmap(id);
}

absl::Status Composer::State::KeepToMemory() {
  const absl::Status status = thinned.KeepToMemory();
  return status.ok() ? cache->KeepToMemory() : status;
}

std::vector<TiledMap::Robot> Composer::State::RobotsInMap() const {
  std::set<uint32_t> numbers;
  for (const auto& [id, composed] : submaps) numbers.insert(composed.robot);
  std::vector<TiledMap::Robot> in_map;
  in_map.reserve(numbers.size());
  for (const uint32_t number : numbers) in_map.push_back({robots[number], number});
  std::sort(in_map.begin(), in_map.end(),
            [](const TiledMap::Robot& l, const TiledMap::Robot& r) { return l.id < r.id; });
  return in_map;
}

}  // namespace isthmus::composition
