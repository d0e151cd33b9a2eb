// The state that a composer keeps from one map to the next. For composer.cc, composer_state.cc and
// composer_tiles.cc alone.
#pragma once

#include <absl/container/flat_hash_map.h>
#include <absl/container/flat_hash_set.h>
#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/composition/box_fields.h"
#include "server/composition/composer.h"
#include "server/composition/thinned_submap.h"
#include "server/composition/thinned_submap_cache.h"
#include "server/composition/tiles/map_file.h"
#include "server/composition/tiles/tile_builder.h"
#include "server/composition/tiles/tile_limit.h"
#include "server/composition/tiles/tiled_map.h"
#include "server/composition/visibility/visibility_filter.h"

namespace isthmus::composition {

inline absl::Status Stopped() { return absl::CancelledError("stopped"); }

// A submap as the tiles have it. Its points are in `thinned`.
struct Composed {
  SubmapId id;
  SubmapFingerprint fingerprint;  // Always with its content.
  bool is_of_file = false;        // Not made by this process.
  Box bounds;                     // Around the thinned points, submap frame.
  uint32_t robot = 0;             // Number, see Composer::State::robots.
  uint32_t frame = 0;
  Pose T_map_submap;
  std::vector<TileKey> tiles;         // At that pose, as in `thinned`.
  std::vector<uint32_t> point_count;  // Points on each of the tiles.
  uint64_t left_out = 0;              // Points, at that pose.
  bool wanted = false;                // By the Compose that is under way.

  // Points in the file may be of another where the content is not known.
  bool IsOf(SubmapFingerprint placed) const {
    if (placed.content == 0 && !is_of_file) placed.content = fingerprint.content;
    return placed == fingerprint;
  }

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.id, self.fingerprint, self.bounds, self.robot, self.frame, self.T_map_submap,
       self.tiles, self.point_count, self.left_out);
  }
};

// A submap's part on a tile: which submap, and which of its tiles this is.
struct OnTile {
  const Composed* composed = nullptr;
  size_t tile = 0;
};

// The tiles of a map, of all frames.
struct MadeMap {
  std::map<TileKey, TilePtr> tiles;                                 // None is null.
  std::map<uint32_t, std::shared_ptr<const TilePyramid>> pyramids;  // The last map's, by frame.
};

struct Composer::State {
  State(const ComposerOptions& given, std::shared_ptr<MapFile> map_file);

  const ComposerOptions options;
  const VoxelGrid grid;
  const TileLayout layout;
  const std::shared_ptr<MapFile> file;  // Null: all stays in memory.
  // Apart, because a large submap's table is slow to clear for every small tile.
  VoxelThinner submap_thinner, tile_thinner;
  std::map<SubmapId, Composed> submaps;  // In the order in which they go into tiles.
  ThinnedSubmapCache thinned;            // Has all of them.
  const std::shared_ptr<TileCache> cache;
  TileBuilder builder;
  MadeMap present;                              // Points in the map, and ...
  MadeMap gone;                                 // ... points dropped from it; see visibility/.
  const std::shared_ptr<MadeTiles> made_tiles;  // Tiles of higher levels.
  absl::flat_hash_set<TileKey> dirty;           // Tiles that are not as `submaps` says.
  TileLimit limit;                              // Knows the tiles of all of `submaps`.
  std::optional<VisibilityFilter> visibility_filter;  // Nothing: all points stay.
  std::vector<RobotId> robots;                        // By number; only grows.
  absl::flat_hash_map<std::string, uint32_t> robot_numbers;
  uint32_t next_frame = 0;
  int last_tiles_remade = 0;
  LeftOut left_out;
  std::vector<std::pair<SubmapId, uint64_t>> found;  // Contents that were not known.
  bool has_failed = false;                           // The last Compose.
  bool is_complete = false;  // The last Compose, if there was one, made its map.
  // State of the Compose under way.
  std::optional<SubmapId> at_hand;
  uint64_t missing = 0;
  Progress progress;
  double share = 0;

  absl::StatusOr<std::shared_ptr<const ComposedMap>> Compose(int64_t revision,
                                                             const std::vector<PlacedSubmap>& given,
                                                             const SubmapReader& reader,
                                                             const Progress& keeps_on,
                                                             uint64_t waiting);
  absl::Status Save();
  // False where there is nothing to restore, or it is none of this; the state is of no use then.
  bool Restore(const std::string& saved);
  uint64_t MadeWith() const;
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io);
  std::map<uint32_t, uint32_t> FramesOf(const std::vector<PlacedSubmap>& placed);
  uint32_t RobotNumber(const RobotId& robot);
  absl::Status PlaceAll(const std::vector<PlacedSubmap>& placed,
                        const std::map<uint32_t, uint32_t>& frames, const SubmapReader& reader);
  absl::Status PlaceSubmap(const PlacedSubmap& placed, uint32_t frame, const SubmapReader& reader);
  absl::StatusOr<std::vector<WeightedPoint>> PointsOf(const PlacedSubmap& placed, bool is_known,
                                                      const SubmapReader& reader,
                                                      Composed* composed);
  bool IsKnown(const PlacedSubmap& placed) const;
  bool KeepsOn() const { return !progress || progress(share); }
  void MarkLost();
  void EnterTiles(const Composed& composed);
  void LeaveTiles(const Composed& composed);
  void ForgetSubmap(const SubmapId& id);
  void DropUnwanted();
  absl::Status KeepToMemory();
  void KeepToLimit();
  absl::Status RemakeTiles(int64_t revision);
  absl::Status RemakeTile(const TileKey& key, std::vector<OnTile> sources, int64_t revision);
  void PutTile(const TileKey& key, TileContent content, int64_t revision, MadeMap* into);
  absl::StatusOr<std::map<TileKey, std::vector<OnTile>>> WhatIsOnDirty() const;
  // A tile of the points that are gone, or of all others. `has_others`: true if there are any of
  // the other kind.
  absl::StatusOr<TileContent> MakeTile(const std::vector<OnTile>& sources, bool of_gone,
                                       bool* has_others);
  absl::Status LookThrough(const SubmapReader& reader);
  LeftOut CountLeftOut() const;
  std::vector<TiledMap::Robot> RobotsInMap() const;
  std::vector<TiledMap::Component> ComponentsIn(MadeMap* made,
                                                const std::map<uint32_t, uint32_t>& frames,
                                                int64_t revision);
  std::shared_ptr<const TiledMap> MapOf(int64_t revision,
                                        const std::map<uint32_t, uint32_t>& frames,
                                        TiledMap::Submaps about);
};

}  // namespace isthmus::composition
