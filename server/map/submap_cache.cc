#include "server/map/submap_cache.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "core/caught.h"
#include "core/concurrency/mutex.h"

namespace isthmus::server {

size_t BytesOf(const Submap& submap) {
  return sizeof(Submap) + submap.keyframes.capacity() * sizeof(Keyframe) +
         submap.points.capacity() * sizeof(SubmapPoint);
}

SubmapCache::SubmapCache(const storage::MapStore* store, size_t max_bytes, OnDamaged on_damaged)
    : store_(store), max_bytes_(max_bytes), on_damaged_(std::move(on_damaged)) {}

std::shared_ptr<const Submap> SubmapCache::Get(const SubmapId& id) {
  return TryGet(id).value_or(nullptr);
}

std::shared_ptr<const Submap> SubmapCache::GetOrThrow(const SubmapId& id) {
  absl::StatusOr<std::shared_ptr<const Submap>> submap = TryGet(id);
  if (absl::IsUnavailable(submap.status()) && store_->IsRemote())
    throw StatusError(submap.status());
  return std::move(submap).value_or(nullptr);
}

absl::StatusOr<std::shared_ptr<const Submap>> SubmapCache::TryGet(const SubmapId& id) {
  {
    MutexLock lock(&mutex_);
    if (const auto it = entries_.find(id); it != entries_.end()) {
      const Entry& entry = it->second;
      if (entry.is_damaged) {
        return absl::DataLossError(absl::StrCat("submap ", ToString(id), " is damaged"));
      }
      if (std::shared_ptr<const Submap> held = entry.held.lock()) {
        KeepEntry(id, held);
        return held;
      }
    }
  }
  // Not under the lock: two who ask for the same at a time read it twice.
  absl::StatusOr<std::shared_ptr<const Submap>> read = Read(id);
  if (read.ok()) {
    MutexLock lock(&mutex_);
    KeepEntry(id, *read);
    return read;
  }
  const bool is_damaged = absl::IsDataLoss(read.status());
  if (!is_damaged && !absl::IsResourceExhausted(read.status())) return read;
  {
    MutexLock lock(&mutex_);
    Entry& entry = entries_[id];
    entry.is_damaged = entry.is_damaged || is_damaged;
    if (std::exchange(entry.is_told, true)) return read;
  }
  if (on_damaged_) on_damaged_(id, std::string(read.status().message()));
  return read;
}

absl::StatusOr<std::shared_ptr<const Submap>> SubmapCache::Read(const SubmapId& id) const {
  try {
    return store_->GetSubmap(id);
  } catch (...) {
    const absl::Status caught = CaughtStatus();
    const std::string problem =
        absl::StrCat("submap ", ToString(id), " cannot be read: ", caught.message());
    if (absl::IsResourceExhausted(caught)) return absl::ResourceExhaustedError(problem);
    return absl::DataLossError(problem);
  }
}

std::shared_ptr<const Submap> SubmapCache::Outline(const SubmapId& id) {
  return TryOutline(id).value_or(nullptr);
}

absl::StatusOr<std::shared_ptr<const Submap>> SubmapCache::TryOutline(const SubmapId& id) {
  {
    MutexLock lock(&mutex_);
    const auto it = entries_.find(id);
    if (it != entries_.end() && it->second.outline) return it->second.outline;
  }
  const absl::StatusOr<std::shared_ptr<const Submap>> read = TryGet(id);
  if (!read.ok()) return read;
  const std::shared_ptr<const Submap>& whole = *read;
  auto outline = std::make_shared<Submap>();
  outline->id = whole->id;
  outline->robot = whole->robot;
  outline->T_odom_submap = whole->T_odom_submap;
  outline->drift_covariance = whole->drift_covariance;
  outline->first_sequence = whole->first_sequence;
  outline->last_sequence = whole->last_sequence;
  outline->first_stamp_ns = whole->first_stamp_ns;
  outline->last_stamp_ns = whole->last_stamp_ns;
  outline->keyframes = whole->keyframes;
  MutexLock lock(&mutex_);
  Entry& entry = entries_[id];
  if (!entry.outline) entry.outline = std::move(outline);
  return entry.outline;
}

void SubmapCache::MarkDamaged(const SubmapId& id, const std::string& problem) {
  {
    MutexLock lock(&mutex_);
    Entry& entry = entries_[id];
    entry.is_damaged = entry.is_told = true;
  }
  if (on_damaged_) on_damaged_(id, problem);
}

void SubmapCache::Put(std::shared_ptr<const Submap> submap) {
  MutexLock lock(&mutex_);
  KeepEntry(submap->id, submap);
}

void SubmapCache::Forget(const SubmapId& id) {
  MutexLock lock(&mutex_);
  kept_.Erase(id);
  entries_.erase(id);
}

size_t SubmapCache::bytes() const {
  MutexLock lock(&mutex_);
  return kept_.weight();
}

void SubmapCache::KeepEntry(const SubmapId& id, const std::shared_ptr<const Submap>& submap) {
  if (kept_.Use(id) != nullptr) return;
  entries_[id].held = submap;
  kept_.Put(id, submap, BytesOf(*submap));
  while (kept_.weight() > max_bytes_ && !kept_.empty()) kept_.DropOldest();
}

}  // namespace isthmus::server
