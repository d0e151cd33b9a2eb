// Submaps that are still on their way in: what has arrived of them outlives the link, and the
// server.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "core/concurrency/mutex.h"
#include "core/ids.h"
#include "core/io/append_file.h"
#include "core/map/submap.h"

namespace isthmus::rpc {

// Which upload, by place and content.
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
  // The upload that one call works on; the bytes that have arrived are in memory while it does.
  class Part {
   public:
    ~Part();
    uint64_t size() const { return data_.size(); }
    // Behind the first `offset` bytes, which have arrived; what was behind them is forgotten.
    // Aborted when a newer call has taken over, ResourceExhausted when the disk is full.
    absl::Status Append(uint64_t offset, const std::string& bytes);
    std::string TakeData() { return std::move(data_); }

   private:
    friend class UploadStaging;
    Part(UploadStaging& staging, UploadKey key) : staging_(staging), key_(std::move(key)) {}

    UploadStaging& staging_;
    const UploadKey key_;
    std::string data_;
    std::unique_ptr<io::AppendFile> file_;  // None: in memory.
    uint64_t header_ = 0;
    uint64_t unsynced_ = 0;
    uint64_t turn_ = 0;
  };

  // Without a folder parts outlive their link only. Parts that nobody has touched for a week are
  // removed. `max_bytes`: of all parts of one session together.
  UploadStaging(std::string folder, uint64_t max_bytes);

  // Goes on with what has arrived of it. ResourceExhausted when the session has too much under way.
  absl::StatusOr<std::unique_ptr<Part>> BeginUpload(const UploadKey& key);
  // Bytes of it that have arrived and are on the disk.
  uint64_t Persisted(const UploadKey& key);
  // It has taken effect, or cannot.
  void Drop(const SubmapId& id);
  // The session takes no more.
  void DropSession(const SessionId& session);

 private:
  struct Entry {
    UploadKey key;
    uint64_t turn = 0;  // Of the newest call for it.
    std::string data;   // Without a folder: what its last call left.
  };

  std::string PathOf(const SubmapId& id) const;
  absl::Status OpenFile(Part& part) const;
  void ReleasePart(Part& part);
  void Forget(const SubmapId& id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Load() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string folder_;
  const uint64_t max_bytes_;
  Mutex mutex_;
  std::map<SubmapId, Entry> entries_ ABSL_GUARDED_BY(mutex_);
  uint64_t turns_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace isthmus::rpc
