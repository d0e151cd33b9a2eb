// A cache of submaps: read from the store when somebody asks, let go when there are too many, so
// that a server's memory does not grow with its map.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "core/concurrency/mutex.h"
#include "core/lru_cache.h"
#include "core/map/submap.h"
#include "storage/map_store.h"

namespace isthmus::server {

// The memory of a submap, about.
size_t BytesOf(const Submap& submap);

// Thread safe.
class SubmapCache {
 public:
  // Told once of each submap that cannot be read, with the store's words; from any thread.
  using OnDamaged = std::function<void(const SubmapId&, const std::string& problem)>;

  // Submaps are let go, those asked for longest ago first, until they take `max_bytes` at most. One
  // that somebody still holds is handed out again, not read a second time, and is not counted.
  SubmapCache(const storage::MapStore* store, size_t max_bytes, OnDamaged on_damaged);
  SubmapCache(const SubmapCache&) = delete;
  SubmapCache& operator=(const SubmapCache&) = delete;

  // Null where it is gone or cannot be read. A damaged one is not read again; where the store
  // failed otherwise, or there is no memory for it, the next call tries again.
  std::shared_ptr<const Submap> Get(const SubmapId& id);
  // The same with the reason: NotFound, DataLoss where it is damaged, or the store's error.
  absl::StatusOr<std::shared_ptr<const Submap>> TryGet(const SubmapId& id);
  // As Get, but throws StatusError where the store is remote and away: a result of several submaps
  // must not come out of some of them because PostgreSQL was restarted.
  std::shared_ptr<const Submap> GetOrThrow(const SubmapId& id);
  // All but its points; kept for good once read, a kB or so each, and always the same object.
  std::shared_ptr<const Submap> Outline(const SubmapId& id);
  absl::StatusOr<std::shared_ptr<const Submap>> TryOutline(const SubmapId& id);

  // Marks one that is damaged in something other than its points: nobody gets it any more.
  void MarkDamaged(const SubmapId& id, const std::string& problem);
  // One that was stored just now.
  void Put(std::shared_ptr<const Submap> submap);
  // One that is gone: should the id come again, it is another submap's.
  void Forget(const SubmapId& id);

  size_t bytes() const;  // Bytes of the submaps kept, without outlines.

 private:
  struct Entry {
    std::weak_ptr<const Submap> held;       // By the cache or somebody else, perhaps.
    std::shared_ptr<const Submap> outline;  // Null until somebody asked.
    bool is_damaged = false;
    bool is_told = false;  // OnDamaged was called.
  };

  // DataLoss also where reading it throws, but where memory ran out ResourceExhausted.
  absl::StatusOr<std::shared_ptr<const Submap>> Read(const SubmapId& id) const;
  void KeepEntry(const SubmapId& id, const std::shared_ptr<const Submap>& submap)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const storage::MapStore* const store_;
  const size_t max_bytes_;
  const OnDamaged on_damaged_;
  mutable Mutex mutex_;
  std::map<SubmapId, Entry> entries_ ABSL_GUARDED_BY(mutex_);
  LruCache<SubmapId, std::shared_ptr<const Submap>> kept_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::server
