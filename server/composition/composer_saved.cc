// The part of the composer's state that outlives the process.
#include <utility>

#include "core/content_hash.h"
#include "core/state_codec.h"
#include "server/composition/composer_state.h"

namespace isthmus::composition {
namespace {

// A tile of a map, and where its points lie.
struct SavedTile {
  TileKey key;
  TileRecord record;
  Extent extent;

  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.key, self.record, self.extent);
  }
};

void TileFields(const MadeMap& map, const TileCache& cache, StateWriter& io) {
  std::vector<SavedTile> tiles;
  tiles.reserve(map.tiles.size());
  for (const auto& [key, tile] : map.tiles) {
    tiles.push_back({key, tile->record(), cache.WhereIs(*tile)});
  }
  io(tiles);
}

void TileFields(MadeMap& map, TileCache& cache, StateReader& io) {
  std::vector<SavedTile> tiles;
  io(tiles);
  for (SavedTile& tile : tiles) {
    map.tiles[tile.key] = cache.Restore(std::move(tile.record), tile.extent);
  }
}

}  // namespace

template <typename Self, typename Io>
void Composer::State::Fields(Self& self, Io& io) {
  io(self.robots, self.next_frame, self.submaps, self.thinned);
  if (self.visibility_filter) io(*self.visibility_filter);
  TileFields(self.present, *self.cache, io);
  TileFields(self.gone, *self.cache, io);
}

// All that thinned submaps and tiles depend on, beside the submaps: the options, and the program.
uint64_t Composer::State::MadeWith() const {
  ContentHash hash;
  hash.AddText(ISTHMUS_VERSION);
  hash.Add(sizeof(WeightedPoint) << 8 | sizeof(TilePoint));
  for (const double value : {options.tile_m, options.voxel_m, options.min_move_m}) {
    hash.AddBytes(&value, sizeof(value));
  }
  hash.Add(static_cast<uint64_t>(options.max_tiles));
  hash.Add(options.drop_gone ? 1 : 0);
  return hash.value();
}

absl::Status Composer::State::Save() {
  absl::Status status = thinned.WriteAll();
  if (status.ok()) status = cache->WriteAll();
  if (!status.ok()) return status;
  StateWriter writer;
  writer(*this);
  std::vector<Extent> extents = thinned.extents();
  for (const MadeMap* map : {&present, &gone}) {
    for (const auto& [key, tile] : map->tiles) extents.push_back(cache->WhereIs(*tile));
  }
  return file->Save(MadeWith(), writer.Take(), extents);
}

bool Composer::State::Restore(const std::string& saved) {
  StateReader reader(saved.data(), saved.size());
  reader(*this);
  if (!reader.ok() || reader.remaining() > 0) return false;
  for (size_t i = 0; i < robots.size(); ++i) {
    robot_numbers[robots[i].value()] = static_cast<uint32_t>(i);
  }
  for (auto& [id, composed] : submaps) {
    if (composed.robot >= robots.size()) return false;
    composed.is_of_file = true;
    EnterTiles(composed);
  }
  dirty.clear();  // All of them are as `submaps` says.
  return true;
}

}  // namespace isthmus::composition
