// Submaps that are still on their way in: the part that has arrived outlives the link, and the
// server.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "core/clock.h"
#include "core/concurrency/mutex.h"
#include "core/ids.h"
#include "core/io/append_file.h"
#include "core/map/submap.h"

namespace isthmus::rpc {

// The name of an upload: its place and content.
struct UploadKey {
  SubmapId id;
  uint64_t size = 0;
  uint32_t crc32c = 0;
  std::string sha256 = {};  // 32 bytes, or none.
  bool operator==(const UploadKey&) const = default;
};

// One file per upload: FOLDER/SESSION-INDEX.part, a line that names the content, then its bytes. At
// most one content per submap: another one takes its place. Thread safe.
class UploadStaging {
 public:
  // The upload that one call works on. Without a folder the bytes that have arrived are in it.
  class Part {
   public:
    ~Part();
    uint64_t size() const { return size_; }
    // Behind the first `offset` bytes, which have arrived; what was behind them is forgotten.
    // Aborted when a newer call has taken over, ResourceExhausted when the disk is full.
    absl::Status Append(uint64_t offset, const std::string& bytes);
    // All that has arrived, as one piece. To be called once, at the end. Aborted as above,
    // Unavailable where the disk cannot be read.
    absl::StatusOr<std::string> TakeData();

   private:
    friend class UploadStaging;
    // Ok while no newer call has taken over.
    absl::Status CheckTurn() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(staging_.mutex_);
    Part(UploadStaging& staging, UploadKey key) : staging_(staging), key_(std::move(key)) {}

    UploadStaging& staging_;
    const UploadKey key_;
    uint64_t size_ = 0;
    std::string data_;                      // In memory only.
    std::unique_ptr<io::AppendFile> file_;  // None: in memory.
    uint64_t header_ = 0;
    uint64_t unsynced_ = 0;
    uint64_t turn_ = 0;
  };

  // Without a folder parts outlive their link only. Parts that nobody has touched for a week are
  // removed. `max_bytes`: of all parts of one session together. The clock must outlive it.
  UploadStaging(std::string folder, uint64_t max_bytes, const Clock& clock = Clock::System());

  // Goes on with what has arrived of it; `taken_over` is called, with a lock held, once another
  // call has begun the same one. ResourceExhausted when the session has too much or too many under
  // way; InvalidArgument for a sha256 of another size than 32.
  absl::StatusOr<std::unique_ptr<Part>> BeginUpload(const UploadKey& key,
                                                    std::function<void()> taken_over = nullptr);
  // Bytes of it that have arrived and are on the disk.
  uint64_t Persisted(const UploadKey& key);
  // Uploads of which some part has arrived. Waits for nobody.
  size_t under_way() const { return under_way_; }
  // It has taken effect, or cannot.
  void Drop(const SubmapId& id);
  // The session takes no more.
  void DropSession(const SessionId& session);

 private:
  struct Entry {
    UploadKey key;
    uint64_t turn = 0;  // The newest call's.
    std::string data;   // Without a folder: what its last call left.
    int64_t touched_ns = 0;
    std::function<void()> taken_over;  // The newest call's, while it lives.
  };

  std::string PathOf(const SubmapId& id) const;
  absl::Status OpenFile(Part& part) const;
  void ReleasePart(Part& part);
  // Ok where the session may have this one under way, too.
  absl::Status CheckRoom(const UploadKey& key) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void ForgetStale() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Forget(const SubmapId& id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Load() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string folder_;
  const uint64_t max_bytes_;
  const Clock& clock_;
  Mutex mutex_;
  std::map<SubmapId, Entry> entries_ ABSL_GUARDED_BY(mutex_);
  std::atomic<size_t> under_way_ = 0;  // The size of entries_.
  uint64_t turns_ ABSL_GUARDED_BY(mutex_) = 0;
};

// The error of a call whose upload another one has begun anew: Aborted.
absl::Status TakenOver();
// InvalidArgument unless it is 32 bytes, or none.
absl::Status CheckSha256(const std::string& sha256);

}  // namespace isthmus::rpc
