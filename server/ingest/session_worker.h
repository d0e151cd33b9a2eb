// One robot's way in: order, duplicates, back-pressure, odometry, submaps, hand-over to the store.
#pragma once

#include <absl/status/status.h>

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/codec/scan_decoder.h"
#include "core/executor.h"
#include "core/scan_upload.h"
#include "core/session.h"
#include "core/submap.h"
#include "core/trajectory.h"
#include "floam/odometry.h"
#include "floam/odometry_options.h"
#include "floam/submap_builder.h"
#include "server/ingest/scan_clock.h"

namespace isthmus::ingest {

// A finished stretch of a session: the submap and the scans that fell into it.
struct Stretch {
  std::shared_ptr<const Submap> submap;
  std::vector<TrajectoryEntry> trajectory;
};

// What a worker asks of its surroundings. Called from executor threads, one call at a time per
// worker, without any of the worker's locks held.
struct WorkerHooks {
  // Makes a stretch durable and hands it on. On error the stretch is kept and offered again.
  std::function<absl::Status(const Stretch&)> persist;
  // The session's newest placement.
  std::function<std::optional<Pose>()> T_map_odom;
  // A scan has been dealt with (its ack was sent).
  std::function<void()> scan_done;
};

// Where a session continues: what is durable of it.
struct ResumePoint {
  std::vector<std::shared_ptr<const Submap>> submaps;  // All, in order.
  std::vector<TrajectoryEntry> trajectory;             // All, in order.
};

struct WorkerStatus {
  uint64_t last_sequence = 0;  // Highest that was dealt with.
  uint64_t durable_sequence = 0;
  uint64_t processed = 0;
  uint64_t rejected = 0;
  double odometry_ms_mean = 0;
  double travelled_m = 0;
  std::string tracking;  // "ok", "degenerate", "lost"; empty before the first scan.
  std::string input;     // How rings and times of the scans were found; empty before the first.
  std::vector<TrajectoryEntry> unsaved;  // Scans whose submap is not finished yet.
};

// What becomes of a scan, and what its ack says:
//   sequence dealt with before        duplicate; nothing happens
//   stamp up to 1 s before the last   rejected as out of order; nothing happens
//   no returns, too few, damaged      rejected, "lost": where the robot was then is not known;
//                                     after three in a row the submap ends
//   cannot be matched                 processed, "lost": the pose is a prediction. The submap ends
//   matched                           processed, "ok" or "degenerate"
// A clock that was set (see ScanClock) ends the submap, so that stamps in it stay in order, and the
// odometry goes on. Scans are stored with the robot's stamps; lost ones are not stored.
//
// Thread safe. Runs at most one task at a time on the executor, which must outlive it.
class SessionWorker : public std::enable_shared_from_this<SessionWorker> {
 public:
  struct Options {
    size_t queue = 16;  // Scans that may wait.
    floam::OdometryOptions odometry;
    floam::SubmapOptions submap;
  };

  static std::shared_ptr<SessionWorker> Create(const SessionRecord& record,
                                               const floam::SensorModel& sensor,
                                               const Options& options, WorkerHooks hooks,
                                               Executor* executor, const ResumePoint& resume);

  // Queues a scan; waits while the queue is full. OutOfRange when the sequence leaves a gap,
  // InvalidArgument for sequence 0, Unavailable once stopped, ResourceExhausted while finished
  // submaps cannot be stored (each call tries once more).
  absl::Status Submit(ScanUpload scan);

  // Where acks go from now on. When it returns, the earlier sink is not called any more.
  void SetAckSink(AckSink sink);

  // Waits for queued scans, then cuts and persists the unfinished submap. Scans submitted meanwhile
  // are refused with Unavailable. Returns what persist said. Idempotent.
  absl::Status Finish();
  // Forgets queued scans and waits for the one in work; nothing more is persisted or acknowledged.
  void Abandon();

  WorkerStatus Status() const;

 private:
  SessionWorker(const SessionRecord& record, const floam::SensorModel& sensor,
                const Options& options, WorkerHooks hooks, Executor* executor,
                const ResumePoint& resume);

  void Resume(const ResumePoint& resume);
  void RunOne();  // Executor task: deals with one scan, posts itself again while there are more.
  ScanAck Handle(const ScanUpload& scan);
  absl::StatusOr<floam::OdometryResult> Track(const ScanUpload& scan, int64_t time_ns);
  void Reject(const absl::Status& why, ScanAck* ack);
  void Take(const floam::OdometryResult& result, ScanAck* ack);
  void Cut(std::shared_ptr<const Submap> submap);
  absl::Status Persist();  // Offers every unpersisted stretch, in order.
  void Send(const ScanAck& ack);

  const SessionRecord record_;
  const Options options_;
  const WorkerHooks hooks_;
  Executor* const executor_;

  // Touched only by the running task, or by Finish when none runs and none can start.
  codec::ScanDecoder decoder_;
  ScanClock clock_;
  floam::Odometry odometry_;
  floam::SubmapBuilder builder_;
  std::vector<TrajectoryEntry> stretch_;  // Of the unfinished submap.
  int blind_scans_ = 0;                   // In a row, up to the last.

  std::mutex persist_mutex_;         // Serialises Persist.
  std::deque<Stretch> unpersisted_;  // Guarded by mutex_.

  std::mutex sink_mutex_;  // Held while an ack is sent.
  AckSink sink_;           // Guarded by sink_mutex_.

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<ScanUpload> queue_;  // Guarded by mutex_, as is all below.
  uint64_t last_submitted_ = 0;
  bool running_ = false;  // A task is posted or at work.
  bool stopping_ = false;
  WorkerStatus status_;
  double odometry_ms_sum_ = 0;
  std::optional<Pose> T_odom_last_;
};

}  // namespace isthmus::ingest
