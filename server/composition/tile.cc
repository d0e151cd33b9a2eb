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
  std::lock_guard lock(mutex_);
  TakeTurn(*tile, std::move(points));
  return tile;
}

void TileCache::TakeTurn(const Tile& tile, std::shared_ptr<const Cloud> points) {
  Turns& turns = TurnsOf(tile);
  turns.bytes += BytesOf(*points);
  tile.points_ = std::move(points);
  tile.turn_ = turns.tiles.insert(turns.tiles.end(), &tile);
}

void TileCache::GiveUpTurn(const Tile& tile) {
  if (tile.points_ == nullptr) return;
  Turns& turns = TurnsOf(tile);
  turns.bytes -= BytesOf(*tile.points_);
  turns.tiles.erase(tile.turn_);
  tile.points_ = nullptr;
}

void TileCache::Forget(const Tile& tile) {
  {
    std::lock_guard lock(mutex_);
    GiveUpTurn(tile);
  }
  if (tile.extent_.size > 0) file_->Free(tile.extent_);
}

absl::StatusOr<std::shared_ptr<const Cloud>> TileCache::PointsOf(const Tile& tile) {
  Extent extent;
  {
    std::lock_guard lock(mutex_);
    if (tile.points_ != nullptr) {
      auto& tiles = TurnsOf(tile).tiles;
      tiles.splice(tiles.end(), tiles, tile.turn_);
      return tile.points_;
    }
    extent = tile.extent_;
  }
  auto read = std::make_shared<Cloud>(tile.point_count());
  const absl::Status status = file_->Read(extent, 0, read->data(), BytesOf(*read));
  if (!status.ok()) return status;
  std::shared_ptr<const Cloud> points = std::move(read);
  std::lock_guard lock(mutex_);
  if (tile.points_ != nullptr) return tile.points_;  // Another reader was faster.
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
  std::lock_guard lock(mutex_);
  GiveUpTurn(*tile);
  tile->extent_ = *extent;
  TakeTurn(*tile, points);
  return absl::OkStatus();
}

absl::Status TileCache::Settle() {
  if (file_ == nullptr) return absl::OkStatus();
  std::unique_lock lock(mutex_);
  if (unsaved_.bytes + saved_.bytes <= max_bytes_) return absl::OkStatus();
  // Half of the memory is for tiles that readers bring back: else those never asked for, but not
  // saved yet, would fill it for good.
  while (unsaved_.bytes > max_bytes_ / 2) {
    const Tile& coldest = *unsaved_.tiles.front();
    TilePtr tile = coldest.weak_from_this().lock();
    if (tile == nullptr) {  // About to go; its thread waits for the lock.
      GiveUpTurn(coldest);
      continue;
    }
    std::shared_ptr<const Cloud> points = tile->points_;
    lock.unlock();  // Readers need not wait for the disk.
    const absl::Status status = Save(tile, points);
    points = nullptr;
    tile = nullptr;  // Perhaps the last to hold it, which takes the lock.
    if (!status.ok()) return status;
    lock.lock();
  }
  DropSaved();
  return absl::OkStatus();
}

size_t TileCache::bytes_in_memory() const {
  std::lock_guard lock(mutex_);
  return unsaved_.bytes + saved_.bytes;
}

}  // namespace isthmus::composition
