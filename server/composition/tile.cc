#include "server/composition/tile.h"

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
  MutexLock lock(&mutex_);
  TakeTurn(*tile, std::move(points));
  return tile;
}

void TileCache::TakeTurn(const Tile& tile, std::shared_ptr<const Cloud> points) {
  Turns& turns = TurnsOf(tile);
  turns.bytes += BytesOf(*points);
  KeptOf(tile).points = std::move(points);
  KeptOf(tile).turn = turns.tiles.insert(turns.tiles.end(), &tile);
}

void TileCache::GiveUpTurn(const Tile& tile) {
  Tile::Kept& kept = KeptOf(tile);
  if (kept.points == nullptr) return;
  Turns& turns = TurnsOf(tile);
  turns.bytes -= BytesOf(*kept.points);
  turns.tiles.erase(kept.turn);
  kept.points = nullptr;
}

void TileCache::Forget(const Tile& tile) {
  Extent extent;
  {
    MutexLock lock(&mutex_);
    GiveUpTurn(tile);
    extent = KeptOf(tile).extent;
  }
  if (extent.size > 0) file_->Free(extent);
}

absl::StatusOr<std::shared_ptr<const Cloud>> TileCache::PointsOf(const Tile& tile) {
  Extent extent;
  {
    MutexLock lock(&mutex_);
    const Tile::Kept& kept = KeptOf(tile);
    if (kept.points != nullptr) {
      auto& tiles = TurnsOf(tile).tiles;
      tiles.splice(tiles.end(), tiles, kept.turn);
      return kept.points;
    }
    extent = kept.extent;
  }
  auto read = std::make_shared<Cloud>(tile.point_count());
  const absl::Status status = file_->Read(extent, 0, read->data(), BytesOf(*read));
  if (!status.ok()) return status;
  std::shared_ptr<const Cloud> points = std::move(read);
  MutexLock lock(&mutex_);
  // Another reader may have been faster.
  if (KeptOf(tile).points != nullptr) return KeptOf(tile).points;
  TakeTurn(tile, points);
  DropSaved();
  return points;
}

void TileCache::DropSaved() {
  while (unsaved_.bytes + saved_.bytes > max_bytes_ && !saved_.tiles.empty()) {
    GiveUpTurn(*saved_.tiles.front());
  }
}

absl::Status TileCache::Save(const TilePtr& tile, const std::shared_ptr<const Cloud>& points) {
  const absl::StatusOr<Extent> extent = file_->Write(points->data(), BytesOf(*points));
  if (!extent.ok()) return extent.status();
  MutexLock lock(&mutex_);
  GiveUpTurn(*tile);
  KeptOf(*tile).extent = *extent;
  TakeTurn(*tile, points);
  return absl::OkStatus();
}

std::pair<TilePtr, std::shared_ptr<const Cloud>> TileCache::NextToSave() {
  MutexLock lock(&mutex_);
  // Half of the memory is for tiles that readers bring back: else those never asked for, but not
  // saved yet, would fill it for good.
  while (unsaved_.bytes > max_bytes_ / 2) {
    const Tile& coldest = *unsaved_.tiles.front();
    if (TilePtr tile = coldest.weak_from_this().lock()) return {tile, KeptOf(*tile).points};
    GiveUpTurn(coldest);  // About to go; its thread waits for the lock.
  }
  return {};
}

absl::Status TileCache::Settle() {
  if (file_ == nullptr || bytes_in_memory() <= max_bytes_) return absl::OkStatus();
  for (;;) {
    // Without the lock: readers need not wait for the disk, and letting go of the tile, perhaps as
    // the last to hold it, takes the lock.
    const auto [tile, points] = NextToSave();
    if (tile == nullptr) break;
    if (absl::Status status = Save(tile, points); !status.ok()) return status;
  }
  MutexLock lock(&mutex_);
  DropSaved();
  return absl::OkStatus();
}

size_t TileCache::bytes_in_memory() const {
  MutexLock lock(&mutex_);
  return unsaved_.bytes + saved_.bytes;
}

}  // namespace isthmus::composition
