#include "server/composition/composer.h"

#include <absl/container/flat_hash_map.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "server/composition/thinned_submap.h"
#include "server/composition/tile_builder.h"
#include "server/composition/tiled_map.h"

namespace isthmus::composition {
namespace {

// A submap as the tiles have it.
struct Composed {
  ThinnedSubmap thinned;
  uint32_t robot = 0;  // Number, see Composer::State::robots.
  uint32_t frame = 0;
  Pose T_map_submap;
  PointsByTile by_tile;  // At that pose.
  bool wanted = false;   // By the Compose that is under way.
};

double InRange(double value, double lowest, double highest, double otherwise) {
  return std::isfinite(value) ? std::clamp(value, lowest, highest) : otherwise;
}

ComposerOptions Sane(const ComposerOptions& given) {
  const ComposerOptions defaults;
  ComposerOptions options;
  options.voxel_m = InRange(given.voxel_m, 0.001, 100, defaults.voxel_m);
  options.tile_m = InRange(given.tile_m, options.voxel_m, 1e5, defaults.tile_m);
  options.min_move_m = InRange(given.min_move_m, 0, 1e5, defaults.min_move_m);
  return options;
}

}  // namespace

struct Composer::State {
  explicit State(const ComposerOptions& given)
      : options(Sane(given)), grid(options.voxel_m), layout(options.tile_m, options.voxel_m) {}

  const ComposerOptions options;
  const VoxelGrid grid;
  const TileLayout layout;
  VoxelThinner thinner;
  std::map<SubmapId, Composed> submaps;  // In the order in which they go into tiles.
  std::map<TileKey, TilePtr> tiles;      // None is null.
  std::vector<RobotId> robots;           // By number; only grows.
  absl::flat_hash_map<std::string, uint32_t> robot_numbers;
  uint32_t next_frame = 0;
  int last_tiles_remade = 0;

  std::map<uint32_t, uint32_t> FramesOf(const std::vector<PlacedSubmap>& placed);
  uint32_t RobotNumber(const RobotId& robot);
  // False, and it is not in the map, when it cannot be read.
  bool Place(const PlacedSubmap& placed, uint32_t frame, const SubmapReader& reader,
             std::set<TileKey>* dirty);
  void DropUnwanted(std::set<TileKey>* dirty);
  void Remake(const std::set<TileKey>& dirty);
  std::vector<TiledMap::Robot> RobotsInMap() const;
};

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

// Brings what is known of one submap up to date; every tile it left, entered or moved on is dirty.
bool Composer::State::Place(const PlacedSubmap& placed, uint32_t frame, const SubmapReader& reader,
                            std::set<TileKey>* dirty) {
  const Pose& T_map_submap = placed.T_map_submap;
  const uint32_t robot = RobotNumber(placed.submap->robot);
  auto [it, is_new] = submaps.try_emplace(placed.submap->id);
  Composed& composed = it->second;
  const SubmapFingerprint fingerprint = FingerprintOf(*placed.submap);
  const bool other_content =
      is_new || composed.robot != robot || composed.thinned.fingerprint != fingerprint;
  std::shared_ptr<const Submap> content;
  if (other_content) {
    content = reader(placed.submap->id);
    // Another one than was meant: the first one's session was deleted meanwhile.
    if (content == nullptr || FingerprintOf(*content) != fingerprint) return false;
  }
  composed.wanted = true;
  if (!other_content && composed.frame == frame &&
      LargestMove(composed.thinned.bounds, composed.T_map_submap, T_map_submap) <=
          options.min_move_m) {
    return true;
  }
  const auto soil = [&] {
    dirty->insert(composed.by_tile.tiles.begin(), composed.by_tile.tiles.end());
  };
  soil();
  if (other_content) composed.thinned = Thin(*content, grid, &thinner);
  composed.robot = robot;
  composed.frame = frame;
  composed.T_map_submap = T_map_submap;
  composed.by_tile = SortByTile(composed.thinned, frame, T_map_submap, grid, layout);
  soil();
  return true;
}

void Composer::State::DropUnwanted(std::set<TileKey>* dirty) {
  for (auto it = submaps.begin(); it != submaps.end();) {
    if (std::exchange(it->second.wanted, false)) {
      ++it;
      continue;
    }
    dirty->insert(it->second.by_tile.tiles.begin(), it->second.by_tile.tiles.end());
    it = submaps.erase(it);
  }
}

void Composer::State::Remake(const std::set<TileKey>& dirty) {
  last_tiles_remade = static_cast<int>(dirty.size());
  std::map<TileKey, std::vector<TileSource>> sources;
  for (const TileKey& key : dirty) sources[key];
  for (const auto& [id, composed] : submaps) {
    for (size_t i = 0; i < composed.by_tile.tiles.size(); ++i) {
      const auto it = sources.find(composed.by_tile.tiles[i]);
      if (it == sources.end()) continue;
      it->second.push_back(
          {&composed.thinned, composed.T_map_submap, composed.robot, composed.by_tile.Of(i)});
    }
  }
  for (auto& [key, of_tile] : sources) {
    if (of_tile.empty()) {
      tiles.erase(key);
    } else {
      tiles[key] = MakeTile(std::move(of_tile), robots, grid, &thinner);
    }
  }
}

std::vector<TiledMap::Robot> Composer::State::RobotsInMap() const {
  std::set<uint32_t> numbers;
  for (const auto& [id, composed] : submaps) numbers.insert(composed.robot);
  std::vector<TiledMap::Robot> in_map;
  for (const uint32_t number : numbers) in_map.push_back({robots[number], number});
  std::sort(in_map.begin(), in_map.end(),
            [](const TiledMap::Robot& l, const TiledMap::Robot& r) { return l.id < r.id; });
  return in_map;
}

Composer::Composer(const ComposerOptions& options) : state_(std::make_unique<State>(options)) {}
Composer::~Composer() = default;

std::shared_ptr<const ComposedMap> Composer::Compose(int64_t revision,
                                                     const std::vector<PlacedSubmap>& given,
                                                     const SubmapReader& reader) {
  std::vector<PlacedSubmap> placed;
  placed.reserve(given.size());
  for (const PlacedSubmap& p : given) {
    const bool usable = p.submap && p.T_map_submap.IsFinite();
    if (usable) placed.push_back(p);
  }

  const std::map<uint32_t, uint32_t> frames = state_->FramesOf(placed);
  std::set<TileKey> dirty;
  uint64_t missing = 0;
  for (const PlacedSubmap& p : placed) {
    missing += !state_->Place(p, frames.at(p.component), reader, &dirty);
  }
  state_->DropUnwanted(&dirty);
  state_->Remake(dirty);

  std::map<uint32_t, uint32_t> component_of_frame;
  for (const auto& [component, frame] : frames) component_of_frame[frame] = component;
  std::vector<TiledMap::Component> components(frames.empty() ? 0 : frames.rbegin()->first + 1);
  for (const auto& [key, tile] : state_->tiles) {
    TiledMap::Component& component = components[component_of_frame.at(key.frame)];
    component.tiles.push_back(tile);
    component.point_count += tile->point_count;
    component.bounds.Extend(tile->bounds);
  }
  return std::make_shared<TiledMap>(revision, state_->RobotsInMap(), std::move(components),
                                    missing);
}

int Composer::last_tiles_remade() const { return state_->last_tiles_remade; }

}  // namespace isthmus::composition
