// Values that are too large for the rows of a database: a bucket has them, and the row a reference.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/time/time.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/concurrency/mutex.h"
#include "core/lru_cache.h"
#include "storage/objects/bucket.h"
#include "storage/objects/limits.h"

namespace isthmus::storage {

// In place of a value: its object, with the size and checksum that it must have.
struct ObjectReference {
  std::string name;  // Behind the folder.
  uint64_t bytes = 0;
  uint32_t crc32c = 0;
};
// Nothing where the row has the value itself.
std::optional<ObjectReference> FindReference(const std::string& in_row);
// Bytes of the value itself, in the row or in the bucket.
uint64_t BytesOfValue(const std::string& in_row);
// No reference has more bytes.
inline constexpr size_t kLongestReference = 100;  // Format.

// An object is written once, under a name of its own, before the row that refers to it, and changes
// no more: so every object that a row refers to is there, and a server that has lost its site
// spoils nothing. Thread safe.
class LargeValues {
 public:
  // Names of objects begin with `folder`, which no other map has. Values below `smallest` bytes
  // stay in their rows.
  LargeValues(std::unique_ptr<Bucket> bucket, std::string folder, size_t smallest = kSmallestObject)
      : bucket_(std::move(bucket)), folder_(std::move(folder)), smallest_(smallest) {}

  // The text for the row: the value itself where it is small. The same value again within
  // kSameObject is the same object: a writer that could not commit tries again once a second.
  // Unavailable, for any reason, where the bucket does not take it: it may tomorrow.
  absl::StatusOr<std::string> Put(std::string value);
  // The value of which the row has this. DataLoss where the object is gone or another one; where
  // the bucket does not give it, Unavailable.
  absl::StatusOr<std::string> Get(std::string in_row);

  // Writes an object that tells people about the others; troubles of the bucket show by it.
  absl::Status Describe(const std::string& text);
  // Reads that object: the troubles of the bucket for a server that only reads.
  absl::Status Check();
  // Names, without the folder, of all that were Put.
  absl::StatusOr<std::vector<std::string>> List();
  absl::Status Delete(const std::string& name) { return bucket_->Delete(folder_ + name); }

 private:
  struct Known {
    std::string in_row;
    absl::Time put;
  };

  const std::unique_ptr<Bucket> bucket_;
  const std::string folder_;
  const size_t smallest_;
  Mutex mutex_;
  LruCache<std::string, Known> known_ ABSL_GUARDED_BY(mutex_);  // By hash: those put last.
};

}  // namespace isthmus::storage
