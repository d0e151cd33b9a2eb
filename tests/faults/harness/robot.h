// A robot that streams its scans from a thread of its own and remembers what it was told.
#pragma once

#include <absl/status/status.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "client/library/client.h"
#include "core/concurrency/mutex.h"

namespace isthmus::faults {

// Acknowledgements of all robots together. Thread safe.
class AckCounter {
 public:
  void Add();
  uint64_t count() const;
  // False when `count` is not reached in time.
  bool WaitFor(uint64_t count, double timeout_s) const;

 private:
  mutable Mutex mutex_;
  mutable CondVar changed_;
  uint64_t count_ ABSL_GUARDED_BY(mutex_) = 0;
};

// The time of a clock that only goes forward.
double NowS();

// Never gives up a server that is gone, and asks for it again soon.
client::ClientOptions PatientClient(const std::string& address);

struct RobotOptions {
  int robot = 0;
  std::string address;
  uint64_t scans = 0;                     // Scans that it drives; 0: until Stop.
  double period_s = 0;                    // Its sensor's; 0: scans come as fast as they are taken.
  client::ScanStreamOptions stream = {};  // `on_ack` is the robot's own.
};

class Robot {
 public:
  // Creates its session. Throws when there is no server.
  Robot(const RobotOptions& options, AckCounter* acks);
  ~Robot();

  void Drive();  // Starts the thread.
  void Stop();   // No further scans; returns at once.
  // Waits until all that was pushed is acknowledged and the session is finished.
  absl::Status Finish();

  const SessionId& session() const { return session_; }
  // These lock.
  uint64_t pushed() const;
  uint64_t durable() const;           // The last scan that it was told to be durable.
  std::vector<ScanAck> acks() const;  // In the order in which they came.
  // When a scan was pushed and when it was acknowledged, by index sequence - 1, seconds of
  // NowS(); shorter while there are fewer.
  std::vector<double> pushed_s() const;
  std::vector<double> acked_s() const;

 private:
  void Push();

  const RobotOptions options_;
  AckCounter* const counter_;
  std::unique_ptr<client::Client> client_;
  SessionId session_;
  std::unique_ptr<client::ScanStream> stream_;
  std::atomic<bool> stopping_ = false;
  mutable Mutex mutex_;
  absl::Status result_ ABSL_GUARDED_BY(mutex_);
  uint64_t pushed_ ABSL_GUARDED_BY(mutex_) = 0;
  std::vector<ScanAck> acks_ ABSL_GUARDED_BY(mutex_);
  std::vector<double> pushed_s_ ABSL_GUARDED_BY(mutex_), acked_s_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace isthmus::faults
