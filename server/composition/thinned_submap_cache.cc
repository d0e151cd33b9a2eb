#include "server/composition/thinned_submap_cache.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace isthmus::composition {
namespace {

// Calls visit(run) for the points on each tile in turn, then for those on none.
template <typename Visit>
void ForEachRun(const std::vector<PointRun>& runs, uint32_t point_count, const Visit& visit) {
  for (const PointRun& run : runs) visit(run);
  std::vector<PointRun> ascending = runs;
  std::sort(ascending.begin(), ascending.end(),
            [](const PointRun& l, const PointRun& r) { return l.begin < r.begin; });
  uint32_t next = 0;
  for (const PointRun& run : ascending) {
    if (next < run.begin) visit(PointRun{next, run.begin});
    next = run.end;
  }
  if (next < point_count) visit(PointRun{next, point_count});
}

// The gone points of a submap, to be compared with the gone points after a change.
class GoneBefore {
 public:
  explicit GoneBefore(const std::vector<WeightedPoint>& points) {
    gone_.reserve(points.size());
    for (const WeightedPoint& point : points) gone_.push_back(point.gone);
  }
  bool Differs(const std::vector<WeightedPoint>& points, const PointRun& run) const {
    for (uint32_t i = run.begin; i < run.end; ++i) {
      if (gone_[i] != points[i].gone) return true;
    }
    return false;
  }

 private:
  std::vector<bool> gone_;
};

}  // namespace

ThinnedSubmapCache::ThinnedSubmapCache(std::shared_ptr<MapFile> file, size_t max_bytes)
    : file_(std::move(file)), max_bytes_(max_bytes) {}

ThinnedSubmapCache::~ThinnedSubmapCache() {
  for (const auto& [id, entry] : entries_) {
    if (entry.extent.size > 0) file_->Free(entry.extent);
  }
}

void ThinnedSubmapCache::Put(const SubmapId& id, std::vector<WeightedPoint> points,
                             PointsByTile by_tile) {
  Erase(id);
  Entry& entry = entries_[id];
  entry.point_count = static_cast<uint32_t>(points.size());
  entry.points = std::move(points);
  entry.runs = std::move(by_tile.runs);
  entry.first_run = std::move(by_tile.begin);
  entry.points.shrink_to_fit();
  entry.runs.shrink_to_fit();
  in_memory_.Put(id, &entry, entry.bytes());
}

void ThinnedSubmapCache::Erase(const SubmapId& id) {
  const auto it = entries_.find(id);
  if (it == entries_.end()) return;
  in_memory_.Erase(id);
  FreeExtent(&it->second);
  entries_.erase(it);
}

void ThinnedSubmapCache::FreeExtent(Entry* entry) {
  if (entry->extent.size > 0) file_->Free(std::exchange(entry->extent, Extent()));
  entry->first_point.clear();
}

absl::StatusOr<std::vector<WeightedPoint>> ThinnedSubmapCache::TakeOut(const SubmapId& id) {
  Entry entry = std::move(entries_.extract(id).mapped());
  const bool is_in_memory = in_memory_.Use(id) != nullptr;
  in_memory_.Erase(id);
  if (is_in_memory) {
    FreeExtent(&entry);
    return std::move(entry.points);
  }
  std::vector<WeightedPoint> by_tile(entry.point_count);
  std::vector<PointRun> runs(entry.first_run.back());
  const size_t point_bytes = by_tile.size() * sizeof(WeightedPoint);
  absl::Status status = file_->Read(entry.extent, 0, by_tile.data(), point_bytes);
  if (status.ok()) {
    status = file_->Read(entry.extent, point_bytes, runs.data(), runs.size() * sizeof(PointRun));
  }
  file_->Free(entry.extent);
  if (!status.ok()) return status;
  std::vector<WeightedPoint> points(entry.point_count);
  auto from = by_tile.begin();
  ForEachRun(runs, entry.point_count, [&](const PointRun& run) {
    std::copy_n(from, run.end - run.begin, points.begin() + run.begin);
    from += run.end - run.begin;
  });
  return points;
}

absl::StatusOr<ThinnedSubmapCache::Piece> ThinnedSubmapCache::PieceOf(const SubmapId& id,
                                                                      size_t tile) {
  Entry& entry = entries_.at(id);
  if (in_memory_.Use(id) != nullptr) {
    const uint32_t begin = entry.first_run[tile], end = entry.first_run[tile + 1];
    return Piece{&entry.points, std::span(entry.runs).subspan(begin, end - begin)};
  }
  const uint32_t begin = entry.first_point[tile], count = entry.first_point[tile + 1] - begin;
  piece_.resize(count);
  const absl::Status status = file_->Read(entry.extent, begin * sizeof(WeightedPoint),
                                          piece_.data(), count * sizeof(WeightedPoint));
  if (!status.ok()) return status;
  piece_run_ = {0, count};
  return Piece{&piece_, std::span(&piece_run_, 1)};
}

absl::StatusOr<std::vector<size_t>> ThinnedSubmapCache::Change(
    const SubmapId& id, const std::function<void(std::span<WeightedPoint>)>& change) {
  Entry& entry = entries_.at(id);
  std::vector<size_t> tiles;
  if (in_memory_.Use(id) == nullptr) {
    const absl::Status status = ChangeInFile(&entry, change, &tiles);
    if (!status.ok()) return status;
    return tiles;
  }
  FreeExtent(&entry);
  const GoneBefore before(entry.points);
  change(entry.points);
  for (size_t tile = 0; tile + 1 < entry.first_run.size(); ++tile) {
    const auto runs =
        std::span(entry.runs)
            .subspan(entry.first_run[tile], entry.first_run[tile + 1] - entry.first_run[tile]);
    if (std::ranges::any_of(
            runs, [&](const PointRun& run) { return before.Differs(entry.points, run); })) {
      tiles.push_back(tile);
    }
  }
  return tiles;
}

// The changed points go to another place of the file, so that half a write spoils nothing.
absl::Status ThinnedSubmapCache::ChangeInFile(
    Entry* entry, const std::function<void(std::span<WeightedPoint>)>& change,
    std::vector<size_t>* tiles) {
  std::vector<WeightedPoint> points(entry->point_count);
  const size_t point_bytes = points.size() * sizeof(WeightedPoint);
  std::vector<char> bytes(1 + point_bytes + entry->first_run.back() * sizeof(PointRun));
  absl::Status status = file_->Read(entry->extent, 0, bytes.data(), bytes.size());
  if (!status.ok()) return status;
  if (point_bytes > 0) std::memcpy(points.data(), bytes.data(), point_bytes);
  const GoneBefore before(points);
  change(points);
  if (point_bytes > 0) std::memcpy(bytes.data(), points.data(), point_bytes);
  const absl::StatusOr<Extent> extent = file_->Write(bytes.data(), bytes.size());
  if (!extent.ok()) return extent.status();
  file_->Free(std::exchange(entry->extent, *extent));
  for (size_t tile = 0; tile + 1 < entry->first_point.size(); ++tile) {
    const PointRun run{entry->first_point[tile], entry->first_point[tile + 1]};
    if (before.Differs(points, run)) tiles->push_back(tile);
  }
  return absl::OkStatus();
}

absl::Status ThinnedSubmapCache::WriteToFile(Entry* entry) {
  // At least one, so that it has an extent.
  std::vector<char> bytes(1 + entry->points.size() * sizeof(WeightedPoint) +
                          entry->runs.size() * sizeof(PointRun));
  char* to = bytes.data();
  const auto append = [&to](const void* data, size_t size) {
    if (size > 0) std::memcpy(to, data, size);
    to += size;
  };
  ForEachRun(entry->runs, entry->point_count, [&](const PointRun& run) {
    append(&entry->points[run.begin], (run.end - run.begin) * sizeof(WeightedPoint));
  });
  append(entry->runs.data(), entry->runs.size() * sizeof(PointRun));
  absl::StatusOr<Extent> extent = file_->Write(bytes.data(), bytes.size());
  if (!extent.ok()) return extent.status();
  entry->extent = *extent;
  uint32_t points = 0;
  for (size_t tile = 0; tile + 1 < entry->first_run.size(); ++tile) {
    entry->first_point.push_back(points);
    for (uint32_t i = entry->first_run[tile]; i < entry->first_run[tile + 1]; ++i) {
      points += entry->runs[i].end - entry->runs[i].begin;
    }
  }
  entry->first_point.push_back(points);
  return absl::OkStatus();
}

absl::Status ThinnedSubmapCache::WriteAll() {
  for (auto& [id, entry] : entries_) {
    if (entry.extent.size > 0) continue;
    if (absl::Status status = WriteToFile(&entry); !status.ok()) return status;
  }
  return absl::OkStatus();
}

std::vector<Extent> ThinnedSubmapCache::extents() const {
  std::vector<Extent> extents;
  extents.reserve(entries_.size());
  for (const auto& [id, entry] : entries_) extents.push_back(entry.extent);
  return extents;
}

absl::Status ThinnedSubmapCache::KeepToMemory() {
  if (file_ == nullptr) return absl::OkStatus();
  while (in_memory_.weight() > max_bytes_) {
    Entry* const entry = in_memory_.oldest().value;
    if (entry->extent.size == 0) {
      if (absl::Status status = WriteToFile(entry); !status.ok()) return status;
    }
    std::vector<WeightedPoint>().swap(entry->points);
    std::vector<PointRun>().swap(entry->runs);
    in_memory_.DropOldest();
  }
  return absl::OkStatus();
}

}  // namespace isthmus::composition
