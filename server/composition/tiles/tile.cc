#include "server/composition/tiles/tile.h"

#include <utility>

namespace isthmus::composition {
namespace {

size_t BytesOf(const Cloud& points) { return points.size() * sizeof(Point); }

}  // namespace

Tile::Tile(std::shared_ptr<TileCache> cache, std::vector<TilePart> parts, const Box& bounds,
           uint64_t point_count)
    : cache_(std::move(cache)),
      parts_(std::move(parts)),
      bounds_(bounds),
      point_count_(point_count) {}

Tile::~Tile() { cache_->Forget(*this); }

absl::StatusOr<std::shared_ptr<const Cloud>> Tile::Points() const {
  return cache_->PointsOf(*this);
}

TileCache::TileCache(std::shared_ptr<SpillFile> file, size_t max_bytes)
    : file_(std::move(file)), max_bytes_(max_bytes) {}

TilePtr TileCache::Add(TileContent content) {
  auto points = std::make_shared<const Cloud>(std::move(content.points));
  auto tile = std::make_shared<const Tile>(shared_from_this(), std::move(content.parts),
                                           content.bounds, points->size());
  const size_t bytes = BytesOf(*points);
  MutexLock lock(&mutex_);
  unsaved_.Put(tile.get(), std::move(points), bytes);
  return tile;
}

void TileCache::Forget(const Tile& tile) {
  Extent extent;
  {
    MutexLock lock(&mutex_);
    unsaved_.Erase(&tile);
    saved_.Erase(&tile);
    extent = ExtentOf(tile);
  }
  if (extent.size > 0) file_->Free(extent);
}

absl::StatusOr<std::shared_ptr<const Cloud>> TileCache::PointsOf(const Tile& tile) {
  Extent extent;
  {
    MutexLock lock(&mutex_);
    extent = ExtentOf(tile);
    if (const auto* points = (extent.size > 0 ? saved_ : unsaved_).Use(&tile)) return *points;
  }
  auto read = std::make_shared<Cloud>(tile.point_count());
  const absl::Status status = file_->Read(extent, 0, read->data(), BytesOf(*read));
  if (!status.ok()) return status;
  std::shared_ptr<const Cloud> points = std::move(read);
  MutexLock lock(&mutex_);
  // Another reader may have been faster.
  if (const auto* faster = saved_.Use(&tile)) return *faster;
  saved_.Put(&tile, points, BytesOf(*points));
  DropSaved();
  return points;
}

void TileCache::DropSaved() {
  while (unsaved_.weight() + saved_.weight() > max_bytes_ && !saved_.empty()) saved_.DropOldest();
}

absl::Status TileCache::SavePoints(const TilePtr& tile,
                                   const std::shared_ptr<const Cloud>& points) {
  const absl::StatusOr<Extent> extent = file_->Write(points->data(), BytesOf(*points));
  if (!extent.ok()) return extent.status();
  MutexLock lock(&mutex_);
  unsaved_.Erase(tile.get());
  ExtentOf(*tile) = *extent;
  saved_.Put(tile.get(), points, BytesOf(*points));
  return absl::OkStatus();
}

std::pair<TilePtr, std::shared_ptr<const Cloud>> TileCache::NextToSave() {
  MutexLock lock(&mutex_);
  // Half of the memory is for tiles that readers bring back: else those never asked for, but not
  // saved yet, would fill it for good.
  while (unsaved_.weight() > max_bytes_ / 2) {
    const auto& coldest = unsaved_.oldest();
    if (TilePtr tile = coldest.key->weak_from_this().lock()) return {tile, coldest.value};
    unsaved_.DropOldest();  // About to go; its thread waits for the lock.
  }
  return {};
}

absl::Status TileCache::KeepToMemory() {
  if (file_ == nullptr || bytes_in_memory() <= max_bytes_) return absl::OkStatus();
  for (;;) {
    // Without the lock: readers need not wait for the disk, and letting go of the tile, perhaps as
    // the last to hold it, takes the lock.
    const auto [tile, points] = NextToSave();
    if (tile == nullptr) break;
    if (absl::Status status = SavePoints(tile, points); !status.ok()) return status;
  }
  MutexLock lock(&mutex_);
  DropSaved();
  return absl::OkStatus();
}

size_t TileCache::bytes_in_memory() const {
  MutexLock lock(&mutex_);
  return unsaved_.weight() + saved_.weight();
}

}  // namespace isthmus::composition
