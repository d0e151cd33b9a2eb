// The way of a topic's clouds to the server, by way of the robot's disk.
#pragma once

#include <absl/status/status.h>

#include <functional>
#include <memory>

#include "client/library/client.h"
#include "client/ros1/parameters.h"
#include "client/ros1/scan_queue.h"
#include "core/concurrency/mutex.h"

namespace isthmus::ros1 {

// Goes on with the spool where an earlier run ended, in its session; where there is none a session
// is opened with the first scan, which tells the sensor. The server may be out of reach at any
// time. When the spool is full its oldest scans are given up (WhenFull::kDropOldest), and what
// happens is told in ROS's log.
class ScanPusher {
 public:
  using OnAck = std::function<void(const ScanAck&)>;
  // The queue must outlive it. `on_ack` is called from a thread of the stream.
  ScanPusher(const Parameters& parameters, ScanQueue& queue, OnAck on_ack);

  // Pushes until the queue is closed. An error is one that only a person can help with.
  absl::Status Run();

 private:
  client::ScanStreamOptions StreamOptions() const;
  absl::Status Resume();
  absl::Status Open();
  absl::Status Push(readers::RecordedScan scan);
  void NoteAssumptions();
  void FinishSession();

  const Parameters parameters_;
  const OnAck on_ack_;
  const std::unique_ptr<readers::ScanReader> reader_;
  size_t assumptions_noted_ = 0;
  Mutex mutex_;    // Guards nothing: it is waited with.
  CondVar acked_;  // After each acknowledgement.
  std::unique_ptr<client::Client> client_;
  std::unique_ptr<client::ScanStream> stream_;  // Last: it uses all else.
};

}  // namespace isthmus::ros1
