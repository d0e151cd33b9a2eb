// The file of the composed map: points of thinned submaps and of tiles, which memory need not hold
// and the next start finds again.
#pragma once

#include <absl/container/flat_hash_map.h>
#include <absl/container/flat_hash_set.h>
#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/concurrency/mutex.h"
#include "core/io/file_io.h"
#include "server/composition/tiles/extent_allocator.h"

namespace isthmus::composition {

// Two files in a folder: composed.points, and composed.index, which says what lies where in it and
// has a checksum of each piece. Both may be removed while no server runs: the map is composed from
// what is stored. What the index names is not written over before the next index is on the disk, so
// that a crash or a power cut leaves the map as it was last saved. Where another process has the
// files, or they cannot be opened, an unnamed file stands in, which nobody finds again.
//
// Thread safe but for TakeSaved and Save, which the thread that composes calls.
class MapFile {
 public:
  // Made in the folder when first used. Nothing is written into the last `reserve_bytes` of its
  // disk: those are for what robots send, which has nowhere else to go.
  MapFile(std::string folder, uint64_t reserve_bytes,
          const io::DiskCalls& disk = io::DiskCalls::System());

  // The state that was saved last, whose extents can then be read; empty if there is none of this
  // `made_with`, a hash over all that points depend on. To be called before anything is written:
  // what was saved before goes otherwise.
  std::string TakeSaved(uint64_t made_with);
  // The next start finds `state` and the extents. Fails as Write does, or as kept() says: what was
  // saved before is then as good as it was.
  absl::Status Save(uint64_t made_with, const std::string& state,
                    const std::vector<Extent>& extents);

  // ResourceExhausted when the disk is full, Unavailable when it fails otherwise; the file is then
  // as before.
  absl::StatusOr<Extent> Write(const void* data, size_t size);
  // `size` bytes that begin `from` bytes into what was written; DataLoss when not all of them can
  // be read, or are not those that were saved.
  absl::Status Read(const Extent& extent, uint64_t from, void* data, size_t size) const;
  // FailedPrecondition, with the way out, where an unnamed file stands in. Known after TakeSaved.
  absl::Status kept() const;

  // The space is used again.
  void Free(const Extent& extent);

  uint64_t bytes_in_use() const;

 private:
  // A piece that was written.
  struct Piece {
    uint64_t size = 0, checksum = 0;
  };

  absl::StatusOr<Extent> Allocate(size_t size);  // Opens the file, too.
  absl::Status Open() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // One of the two files. NotFound where it is not there; FailedPrecondition, with the way out,
  // where it cannot be opened or is none. Never waits, as opening a pipe does.
  absl::StatusOr<io::File> OpenOwn(const char* name, int flags) const;
  // The points, for this process alone.
  absl::StatusOr<io::File> OpenPoints(int flags) const;
  absl::StatusOr<std::string> ReadIndex() const;
  bool TakeIndex(uint64_t made_with, const std::string& index, std::string* state)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  std::string IndexOf(uint64_t made_with, const std::string& state,
                      const std::vector<Extent>& extents) const;
  absl::Status Verify(const Extent& extent) const;
  absl::Status ReadBytes(uint64_t offset, void* data, size_t size) const;
  void GiveBack(const Extent& extent) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  std::string PathOf(const char* name) const { return folder_ + "/" + name; }

  const std::string folder_;
  const uint64_t reserve_bytes_;
  const io::DiskCalls& disk_;
  mutable Mutex mutex_;
  io::File file_;  // Opened under the lock by the first who needs it, then left as it is.
  bool is_named_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status kept_ ABSL_GUARDED_BY(mutex_);
  ExtentAllocator extents_ ABSL_GUARDED_BY(mutex_);
  uint64_t length_ ABSL_GUARDED_BY(mutex_) = 0;  // The file's length, at most.
  absl::flat_hash_map<uint64_t, Piece> pieces_ ABSL_GUARDED_BY(mutex_);  // By offset.
  absl::flat_hash_set<uint64_t> saved_ ABSL_GUARDED_BY(mutex_);          // Named by the index.
  std::vector<Extent> held_ ABSL_GUARDED_BY(mutex_);  // Free once there is another index.
  // Pieces of an earlier process that were not looked at yet.
  mutable absl::flat_hash_set<uint64_t> unverified_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::composition
