#include "server/composition/composer.h"

#include <absl/strings/str_cat.h>

#include <map>
#include <set>
#include <string>
#include <utility>

#include "server/composition/composer_state.h"

namespace isthmus::composition {
namespace {

std::shared_ptr<MapFile> FileFor(const ComposerOptions& options) {
  if (options.folder.empty()) return nullptr;
  return std::make_shared<MapFile>(options.folder, options.reserve_bytes);
}

}  // namespace

Composer::Composer(const ComposerOptions& options) : Composer(options, FileFor(options)) {}
Composer::Composer(const ComposerOptions& options, std::shared_ptr<MapFile> file)
    : state_(std::make_unique<State>(options, file)) {
  if (file == nullptr) return;
  const std::string saved = file->TakeSaved(state_->MadeWith());
  if (saved.empty() || state_->Restore(saved)) return;
  file = FileFor(options);
  state_ = std::make_unique<State>(options, std::move(file));
}
Composer::~Composer() { TellLost(nullptr); }

absl::StatusOr<std::shared_ptr<const ComposedMap>> Composer::Compose(
    int64_t revision, const std::vector<PlacedSubmap>& given, const SubmapReader& reader,
    const Progress& progress, uint64_t waiting) {
  state_->is_complete = false;
  auto map = state_->Compose(revision, given, reader, progress, waiting);
  // Each time a submap was forgotten that cannot be read back; it is read from the store now.
  for (size_t left = given.size(); absl::IsDataLoss(map.status()) && left > 0; --left) {
    map = state_->Compose(revision, given, reader, progress, waiting);
  }
  state_->is_complete = map.ok();
  state_->has_failed = !map.ok();
  // The file is for what memory has no room for.
  if (absl::IsResourceExhausted(map.status())) {
    return absl::ResourceExhaustedError(
        absl::StrCat(map.status().message(), " or give the server more memory (cache_mb)"));
  }
  return map;
}

std::set<SubmapId> Composer::Known(const std::vector<PlacedSubmap>& submaps) const {
  std::set<SubmapId> known;
  for (const PlacedSubmap& placed : submaps) {
    if (placed.submap && state_->IsKnown(placed)) known.insert(placed.submap->id);
  }
  return known;
}

std::vector<std::pair<SubmapId, uint64_t>> Composer::TakeContents() {
  return std::exchange(state_->found, {});
}

absl::Status Composer::Save() {
  if (absl::Status status = kept(); !status.ok()) return status;
  const bool can_save = state_->file != nullptr && state_->is_complete;
  return can_save ? state_->Save() : absl::OkStatus();
}

absl::Status Composer::kept() const {
  return state_->file != nullptr ? state_->file->kept() : absl::OkStatus();
}

bool Composer::has_lost() const { return state_->has_failed || state_->cache->has_lost(); }
void Composer::TellLost(std::function<void()> on_lost) {
  state_->cache->TellLost(std::move(on_lost));
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
