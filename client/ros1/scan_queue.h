// A bounded queue of clouds from ROS's threads to the one that pushes them.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "client/readers/messages/message_file.h"
#include "client/readers/recording.h"
#include "core/concurrency/mutex.h"

namespace isthmus::ros1 {

// Thread safe. When it is full the oldest is dropped: a callback of ROS must not wait, and of a
// robot the present matters most.
class ScanQueue {
 public:
  explicit ScanQueue(size_t limit) : limit_(limit) {}

  // Takes a serialised PointCloud2. False when another was dropped for it.
  bool Add(std::string bytes, int64_t received_ns);
  // No more come; what is there is still given out.
  void Close();
  uint64_t dropped() const;

  struct Entry {
    std::string bytes;
    int64_t received_ns = 0;
  };
  // Waits for one; empty once closed.
  std::optional<Entry> Take();

 private:
  const size_t limit_;
  mutable Mutex mutex_;
  CondVar changed_;
  std::deque<Entry> entries_ ABSL_GUARDED_BY(mutex_);
  uint64_t dropped_ ABSL_GUARDED_BY(mutex_) = 0;
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
};

// The queue as a recording of one topic: clouds are understood, stamped and refused as those of a
// bag are. Next waits for a scan. The queue must outlive it.
std::unique_ptr<readers::ScanReader> ReadQueue(ScanQueue& queue, const std::string& topic,
                                               const readers::ReadOptions& options);

}  // namespace isthmus::ros1
