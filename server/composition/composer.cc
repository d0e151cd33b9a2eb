#include "server/composition/composer.h"

#include <map>
#include <utility>

#include "server/composition/composer_state.h"

namespace isthmus::composition {
namespace {

std::shared_ptr<SpillFile> FileFor(const ComposerOptions& options) {
  if (options.spill_folder.empty()) return nullptr;
  return std::make_shared<SpillFile>(options.spill_folder, options.spill_reserve_bytes);
}

}  // namespace

Composer::Composer(const ComposerOptions& options) : Composer(options, FileFor(options)) {}
Composer::Composer(const ComposerOptions& options, std::shared_ptr<SpillFile> file)
    : state_(std::make_unique<State>(options, std::move(file))) {}
Composer::~Composer() = default;

absl::StatusOr<std::shared_ptr<const ComposedMap>> Composer::Compose(
    int64_t revision, const std::vector<PlacedSubmap>& given, const SubmapReader& reader,
    const Progress& progress, uint64_t waiting) {
  std::vector<PlacedSubmap> placed;
  placed.reserve(given.size());
  for (const PlacedSubmap& p : given) {
    const bool usable = p.submap && p.T_map_submap.IsFinite();
    if (usable) placed.push_back(p);
  }

  state_->at_hand.reset();
  state_->last_tiles_remade = 0;
  state_->progress = progress;
  state_->share = 0;
  const std::map<uint32_t, uint32_t> frames = state_->FramesOf(placed);
  absl::Status status = state_->KeepToMemory();  // Left to do if an earlier call failed.
  if (status.ok()) status = state_->PlaceAll(placed, frames, reader);
  if (!status.ok()) return status;
  state_->DropUnwanted();
  if (status = state_->LookThrough(reader); !status.ok()) return status;
  state_->KeepToLimit();
  if (status = state_->RemakeTiles(revision); !status.ok()) return status;
  state_->left_out = state_->CountLeftOut();
  TiledMap::Submaps about{.missing = state_->missing, .waiting = waiting};
  for (const PlacedSubmap& p : placed) about.places.emplace(p.submap->id.session, p.component);
  return state_->MapOf(revision, frames, std::move(about));
}

std::optional<SubmapId> Composer::at_hand() const { return state_->at_hand; }
int Composer::last_tiles_remade() const { return state_->last_tiles_remade; }
Composer::LeftOut Composer::left_out() const { return state_->left_out; }

Composer::Memory Composer::memory() const {
  const size_t views = state_->visibility_filter ? state_->visibility_filter->bytes_in_memory() : 0;
  return {state_->thinned.bytes_in_memory() + views, state_->cache->bytes_in_memory(),
          state_->file ? state_->file->bytes_in_use() : 0};
}

}  // namespace isthmus::composition
