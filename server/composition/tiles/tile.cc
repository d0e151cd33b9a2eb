#include "server/composition/tiles/tile.h"

#include <utility>

namespace isthmus::composition {
namespace {

size_t BytesOf(const std::vector<TilePoint>& points) { return points.size() * sizeof(TilePoint); }

// Ranges of a level's points among all points of the tile.
std::vector<std::pair<uint32_t, uint32_t>> RangesOf(const Tile& tile, uint32_t level) {
  std::vector<std::pair<uint32_t, uint32_t>> ranges;
  ranges.reserve(tile.parts().size());
  for (const TilePart& part : tile.parts()) ranges.emplace_back(part.begin, part.EndOf(level));
  return ranges;
}

// The points of a level alone.
absl::StatusOr<TilePoints> ReadLevel(const MapFile& file, const Extent& extent, const Tile& tile,
                                     uint32_t level) {
  TilePoints read;
  uint32_t size = 0;
  for (const TilePart& part : tile.parts()) {
    read.ranges.emplace_back(size, size + part.EndOf(level) - part.begin);
    size = read.ranges.back().second;
  }
  auto points = std::make_shared<std::vector<TilePoint>>(size);
  for (size_t i = 0; i < read.ranges.size(); ++i) {
    const auto [begin, end] = read.ranges[i];
    const absl::Status status =
        file.Read(extent, uint64_t{tile.parts()[i].begin} * sizeof(TilePoint),
                  points->data() + begin, (end - begin) * sizeof(TilePoint));
    if (!status.ok()) return status;
  }
  read.points = std::move(points);
  return read;
}

}  // namespace

Tile::Tile(std::shared_ptr<TileCache> cache, TileRecord record)
    : cache_(std::move(cache)), record_(std::move(record)) {}

Tile::~Tile() { cache_->Forget(*this); }

absl::StatusOr<TilePoints> Tile::Points(uint32_t level) const {
  return cache_->PointsOf(*this, level);
}

TileCache::TileCache(std::shared_ptr<MapFile> file, size_t max_bytes)
    : file_(std::move(file)), max_bytes_(max_bytes) {}

TilePtr TileCache::Add(TileContent content) {
  auto points = std::make_shared<const std::vector<TilePoint>>(std::move(content.points));
  auto tile = std::make_shared<const Tile>(shared_from_this(), std::move(content.record));
  const size_t bytes = BytesOf(*points);
  MutexLock lock(&mutex_);
  unsaved_.Put(tile.get(), std::move(points), bytes);
  return tile;
}

TilePtr TileCache::Restore(TileRecord record, const Extent& extent) {
  auto tile = std::make_shared<const Tile>(shared_from_this(), std::move(record));
  MutexLock lock(&mutex_);
  ExtentOf(*tile) = extent;
  return tile;
}

Extent TileCache::WhereIs(const Tile& tile) const {
  MutexLock lock(&mutex_);
  return ExtentOf(tile);
}

void TileCache::Forget(const Tile& tile) {
  Extent extent;
  {
    MutexLock lock(&mutex_);
    unsaved_.Erase(&tile);
    saved_.Erase(&tile);
    lost_.erase(&tile);
    extent = ExtentOf(tile);
  }
  if (extent.size > 0) file_->Free(extent);
}

std::pair<TileCache::Held, Extent> TileCache::Find(const Tile& tile) {
  MutexLock lock(&mutex_);
  const Extent extent = ExtentOf(tile);
  const Held* held = (extent.size > 0 ? saved_ : unsaved_).Use(&tile);
  return {held != nullptr ? *held : nullptr, extent};
}

absl::StatusOr<TileCache::Held> TileCache::ReadWhole(const Tile& tile, const Extent& extent) {
  auto read = std::make_shared<std::vector<TilePoint>>(tile.point_count());
  const absl::Status status = file_->Read(extent, 0, read->data(), BytesOf(*read));
  if (!status.ok()) return status;
  Held points = std::move(read);
  MutexLock lock(&mutex_);
  // Another reader may have been faster.
  if (const Held* faster = saved_.Use(&tile)) return *faster;
  saved_.Put(&tile, points, BytesOf(*points));
  DropSaved();
  return points;
}

absl::StatusOr<TilePoints> TileCache::PointsOf(const Tile& tile, uint32_t level) {
  auto [held, extent] = Find(tile);
  if (held == nullptr) {
    if (level > 0) {
      absl::StatusOr<TilePoints> part = ReadLevel(*file_, extent, tile, level);
      if (!part.ok()) return NoteLost(tile, part.status());
      return part;
    }
    absl::StatusOr<Held> read = ReadWhole(tile, extent);
    if (!read.ok()) return NoteLost(tile, read.status());
    held = *std::move(read);
  }
  return TilePoints{std::move(held), RangesOf(tile, level)};
}

absl::Status TileCache::NoteLost(const Tile& tile, const absl::Status& why) {
  {
    MutexLock lock(&mutex_);
    lost_.insert(&tile);
  }
  {
    MutexLock lock(&telling_);
    if (on_lost_) on_lost_();
  }
  return absl::UnavailableError(absl::StrCat(
      why.message(), "; this part of the map is composed again: ask again in a moment"));
}

std::set<const Tile*> TileCache::TakeLost() {
  MutexLock lock(&mutex_);
  return std::exchange(lost_, {});
}

bool TileCache::has_lost() const {
  MutexLock lock(&mutex_);
  return !lost_.empty();
}

void TileCache::TellLost(std::function<void()> on_lost) {
  MutexLock lock(&telling_);
  on_lost_ = std::move(on_lost);
}

void TileCache::DropSaved() {
  while (unsaved_.weight() + saved_.weight() > max_bytes_ && !saved_.empty()) saved_.DropOldest();
}

absl::Status TileCache::SavePoints(const TilePtr& tile, const Held& points) {
  const absl::StatusOr<Extent> extent = file_->Write(points->data(), BytesOf(*points));
  if (!extent.ok()) return extent.status();
  MutexLock lock(&mutex_);
  unsaved_.Erase(tile.get());
  ExtentOf(*tile) = *extent;
  saved_.Put(tile.get(), points, BytesOf(*points));
  return absl::OkStatus();
}

std::pair<TilePtr, TileCache::Held> TileCache::NextToSave(size_t unsaved_bytes) {
  MutexLock lock(&mutex_);
  while (unsaved_.weight() > unsaved_bytes) {
    const auto& coldest = unsaved_.oldest();
    if (TilePtr tile = coldest.key->weak_from_this().lock()) return {tile, coldest.value};
    unsaved_.DropOldest();  // About to go; its thread waits for the lock.
  }
  return {};
}

absl::Status TileCache::SaveDownTo(size_t unsaved_bytes) {
  for (;;) {
    // Without the lock: readers need not wait for the disk, and letting go of the tile, perhaps as
    // the last to hold it, takes the lock.
    const auto [tile, points] = NextToSave(unsaved_bytes);
    if (tile == nullptr) return absl::OkStatus();
    if (absl::Status status = SavePoints(tile, points); !status.ok()) return status;
  }
}

absl::Status TileCache::WriteAll() { return SaveDownTo(0); }

absl::Status TileCache::KeepToMemory() {
  if (file_ == nullptr || bytes_in_memory() <= max_bytes_) return absl::OkStatus();
  // Half of the memory is for tiles that readers bring back: else those never asked for, but not
  // saved yet, would fill it for good.
  if (absl::Status status = SaveDownTo(max_bytes_ / 2); !status.ok()) return status;
  MutexLock lock(&mutex_);
  DropSaved();
  return absl::OkStatus();
}

size_t TileCache::bytes_in_memory() const {
  MutexLock lock(&mutex_);
  return unsaved_.weight() + saved_.weight();
}

}  // namespace isthmus::composition
