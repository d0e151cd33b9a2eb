// One robot of the load generator: sends a drive at the sensor's rate and notes what comes back.
#pragma once

#include <absl/status/status.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/library/client.h"
#include "core/concurrency/mutex.h"
#include "core/records/session_status.h"
#include "lab/loadgen/drives.h"
#include "lab/loadgen/relay.h"

namespace isthmus::loadgen {

struct RobotPlan {
  std::string name;
  std::string server;  // host:port, or unix:PATH.
  std::shared_ptr<const Drive> drive;
  size_t first_scan = 0;  // Index in the drive.
  size_t scans = 0;       // To send; fewer where the drive ends.
  double rate_hz = 10;    // 0: as fast as the server takes them.
  bool is_beside =
      false;            // Sends its drive over and over until it is stopped, and finishes nothing.
  double start_s = 0;   // Later than the others, from now.
  double jitter_s = 0;  // Scans are ready up to this much late.
  LinkProfile link;
  WhenBehind when_behind = WhenBehind::kWait;
  uint64_t seed = 1;
};

struct RobotResult {
  std::string name;
  uint64_t pushed = 0, processed = 0, rejected = 0, duplicates = 0;
  uint64_t skipped = 0;     // By a session that keeps the newest.
  uint64_t unanswered = 0;  // Pushed, and never acknowledged.
  uint64_t late = 0;        // Scans that could not be pushed before the next one was ready.
  int reconnects = 0;
  uint64_t cloud_bytes = 0;     // Sent of clouds, what was sent again included.
  uint64_t most_undurable = 0;  // Scans acknowledged and not yet durable, at most.
  uint64_t lost = 0;            // Scans in which the odometry did not follow the robot.
  std::string first_rejection;
  std::vector<double> ack_ms;       // From the instant a scan is due to its acknowledgement.
  std::vector<double> odometry_ms;  // As the server measures it.
  double finish_s = 0;              // Waiting for the last acknowledgement, and finishing.
  absl::Status status;
};

// Thread safe.
class LoadRobot {
 public:
  explicit LoadRobot(RobotPlan plan);

  // Opens a session, sends the scans, finishes the session. Once.
  void Run();
  // Run ends soon.
  void Stop() { stopped_ = true; }

  // After Run has returned.
  RobotResult Result();
  uint64_t acknowledged() const;

 private:
  absl::Status Drive(client::Client& client);
  absl::Status Send(client::ScanStream& stream);
  void Note(const ScanAck& ack);

  const RobotPlan plan_;
  std::atomic<bool> stopped_ = false;
  mutable Mutex mutex_;
  RobotResult result_ ABSL_GUARDED_BY(mutex_);
  std::vector<double> due_s_ ABSL_GUARDED_BY(mutex_);  // Each scan's, by sequence.
};

}  // namespace isthmus::loadgen
