#include "client/ros1/scan_queue.h"

#include <utility>

#include "client/readers/messages/cloud_reader.h"

namespace isthmus::ros1 {
namespace {

class QueueReader : public readers::MessageReader {
 public:
  explicit QueueReader(ScanQueue& queue) : queue_(queue) {}

  absl::StatusOr<std::optional<readers::Message>> Next() override {
    std::optional<ScanQueue::Entry> entry = queue_.Take();
    if (!entry) return std::nullopt;
    current_ = *std::move(entry);
    return readers::Message{0, current_.received_ns, current_.bytes};
  }

 private:
  ScanQueue& queue_;
  ScanQueue::Entry current_;
};

}  // namespace

bool ScanQueue::Add(std::string bytes, int64_t received_ns) {
  MutexLock lock(&mutex_);
  const bool is_full = entries_.size() >= limit_;
  if (is_full) {
    entries_.pop_front();
    ++dropped_;
  }
  entries_.push_back({std::move(bytes), received_ns});
  changed_.Signal();
  return !is_full;
}

void ScanQueue::Close() {
  MutexLock lock(&mutex_);
  closed_ = true;
  changed_.SignalAll();
}

uint64_t ScanQueue::dropped() const {
  MutexLock lock(&mutex_);
  return dropped_;
}

std::optional<ScanQueue::Entry> ScanQueue::Take() {
  MutexLock lock(&mutex_);
  while (entries_.empty() && !closed_) changed_.Wait(&mutex_);
  if (entries_.empty()) return std::nullopt;
  Entry entry = std::move(entries_.front());
  entries_.pop_front();
  return entry;
}

std::unique_ptr<readers::ScanReader> ReadQueue(ScanQueue& queue, const std::string& topic,
                                               const readers::ReadOptions& options) {
  return readers::ReadClouds({topic, "sensor_msgs/PointCloud2", "ros1"},
                             readers::ScanMessage::kPointCloud2,
                             std::make_unique<QueueReader>(queue), options);
}

}  // namespace isthmus::ros1
