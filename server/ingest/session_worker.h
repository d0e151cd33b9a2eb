// One robot's way in: order, duplicates, back-pressure, odometry, submaps, hand-over to the store.
#pragma once

#include <absl/status/status.h>

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/executor.h"
#include "core/scan_upload.h"
#include "core/session.h"
#include "core/submap.h"
#include "core/trajectory.h"
#include "floam/odometry.h"
#include "floam/odometry_options.h"
#include "floam/submap_builder.h"
#include "server/ingest/session_state.h"

namespace isthmus::ingest {

// What a worker that comes after this one needs to go on exactly.
struct Checkpoint {
  uint64_t sequence = 0;  // The last scan dealt with.
  // Up to here all that scans made is in finished submaps: safe without `state`.
  uint64_t durable_sequence = 0;
  std::optional<std::string> state = {};  // Absent on resuming: it is damaged.
  uint32_t segment = 1;                   // That the session is in. Not known on resuming.
};

// What is to be made durable, together or not at all.
struct Stretch {
  std::shared_ptr<const Submap> submap = {};     // Finished; null where there is only a checkpoint.
  std::vector<TrajectoryEntry> trajectory = {};  // The scans that fell into it.
  uint32_t segment = 1;                          // Of both.
  std::optional<Checkpoint> checkpoint = {};     // With its state; maybe in a later segment.
};

// What a worker asks of its surroundings. Called from executor threads, one call at a time per
// worker, without any of the worker's locks held.
struct WorkerHooks {
  // Makes a stretch durable and hands it on. On error the stretch is kept and offered again.
  std::function<absl::Status(const Stretch&)> persist;
  // The segment's newest placement.
  std::function<std::optional<Pose>(uint32_t segment)> T_map_odom;
  // A scan has been dealt with (its ack was sent).
  std::function<void()> scan_done;
  // The session got lost, was found again, began a segment: a sentence for the log. May be null.
  std::function<void(const std::string&)> tell = {};
};

// What is durable of one segment.
struct StoredSegment {
  uint32_t segment = 1;
  uint32_t next_index = 0;     // One more than that of the last submap.
  uint64_t last_sequence = 0;  // Of the last submap.
  // Calls with every submap that can be read, one at a time, in order. May be null: there are none.
  std::function<void(const std::function<void(const Submap&)>&)> for_each_submap = {};
  std::vector<TrajectoryEntry> trajectory = {};  // All, in order.
};

// Where a session continues: what is durable of it.
struct ResumePoint {
  std::optional<Checkpoint> checkpoint = {};
  std::vector<StoredSegment> segments = {};  // In order; none in a new session.
};

struct WorkerStatus {
  uint64_t last_sequence = 0;  // Highest that was dealt with.
  uint64_t durable_sequence = 0;
  uint64_t processed = 0;  // By this worker, as the next.
  uint64_t rejected = 0;
  ScanCounts scans;           // From the session's first scan on, if its checkpoints were usable.
  uint32_t segment = 1;       // That the session is in.
  int64_t lost_since_ns = 0;  // END of the first scan since it was tracked last; 0: it is.
  double odometry_ms_mean = 0;
  double travelled_m = 0;
  std::string tracking;  // "ok", "degenerate", "lost"; empty before the first scan.
  // How rings and times of the scans were found, empty before the first; and `resumed`.
  std::string input;
  // "resumed from submaps: ..." and why, where there was a checkpoint that could not be used.
  std::string resumed;
  // Scans whose submap is not stored yet, by segment.
  std::map<uint32_t, std::vector<TrajectoryEntry>> unsaved;
};

// What becomes of a scan, and what its ack says:
//   sequence dealt with before        duplicate; nothing happens
//   stamp up to 1 s before the last   rejected as out of order; nothing happens
//   no returns, too few, damaged      rejected, "lost": where the robot was then is not known;
//                                     after three in a row the submap ends
//   cannot be matched                 processed, "lost": the pose is a prediction. The submap ends
//   matched                           processed, "ok" or "degenerate"
// Where the odometry gives up looking for a lost robot and begins a new segment, the submaps of the
// old one end, and those of the new one are of the session SegmentId(record.id, segment), counted
// from 0; sequences go on. A checkpoint follows at once, so that the segment is known to the store
// before the robot hears of it.
//
// A clock that was set (see ScanClock) ends the submap, so that stamps in it stay in order, and the
// odometry goes on. Scans are stored with the robot's stamps; lost ones are not stored.
//
// Durable is a scan whose effect is stored: with every finished submap, and after every so many
// scans without one, all that the next scan depends on is handed over too (a checkpoint). A worker
// that resumes from it makes the same poses and submaps, bit for bit, as if nothing had happened,
// given the scans after it once more; those up to it are duplicates. Where a checkpoint cannot be
// used it goes on from the last segment's submaps alone, in the same odom frame but with a map that
// is thinner, or, where that segment has none, in a new one, and says so in WorkerStatus. What a
// carried robot is looked for in is made from the stored submaps: where some were retired since, a
// search may end otherwise than it would have.
//
// Thread safe. Runs at most one task at a time on the executor, which must outlive it.
class SessionWorker : public std::enable_shared_from_this<SessionWorker> {
 public:
  struct Options {
    size_t queue = 16;  // Scans that may wait.
    floam::OdometryOptions odometry;
    floam::SubmapOptions submap;
    uint64_t checkpoint_scans = 200;  // A checkpoint at least after so many.
  };

  static std::shared_ptr<SessionWorker> Create(const SessionRecord& record,
                                               const floam::SensorModel& sensor,
                                               const Options& options, WorkerHooks hooks,
                                               Executor* executor, const ResumePoint& resume);

  // Queues a scan; waits while the queue is full. OutOfRange when the sequence leaves a gap,
  // InvalidArgument for sequence 0, Unavailable once stopped, ResourceExhausted while finished
  // submaps and checkpoints cannot be stored (each call tries once more).
  absl::Status Submit(ScanUpload scan);

  // Where acks go from now on. When it returns, the earlier sink is not called any more.
  void SetAckSink(AckSink sink);

  // Waits for queued scans, then cuts and persists the unfinished submap, with a checkpoint. Scans
  // submitted meanwhile are refused with Unavailable. Returns what persist said. Idempotent.
  absl::Status Finish();
  // Offers what could not be stored once more, and tells the robot if more is durable then. Returns
  // what persist said; OK when nothing waits.
  absl::Status RetryStoring();
  // Forgets queued scans and waits for the one in work; nothing more is persisted or acknowledged.
  void Abandon();

  WorkerStatus Status() const;
  // Status().last_sequence, without the rest, which is long.
  uint64_t last_sequence() const;
  const RobotId& robot() const { return record_.robot; }

 private:
  SessionWorker(const SessionRecord& record, const floam::SensorModel& sensor,
                const Options& options, WorkerHooks hooks, Executor* executor,
                const ResumePoint& resume);

  void Resume(const ResumePoint& resume);
  void MakeState(uint32_t segment, uint32_t first_index);
  // Has the odometry remember the submaps of its segment; appends their points near the last pose,
  // odom frame, to `around` if it is not null.
  void Remember(const ResumePoint& resume, Cloud* around);
  void Follow(const TrajectoryEntry& entry);
  // Where there is no checkpoint, or none that can be used.
  void ResumeFromSubmaps(const ResumePoint& resume);
  void RunOne();  // Executor task: deals with one scan, posts itself again while there are more.
  ScanAck Handle(const ScanUpload& scan);
  void DealWith(const ScanUpload& scan, ScanAck* ack);
  absl::StatusOr<floam::OdometryResult> Track(const ScanUpload& scan, int64_t time_ns);
  void Reject(const ScanUpload& scan, const absl::Status& why, ScanAck* ack);
  void Take(const floam::OdometryResult& result, ScanAck* ack);
  void BeginSegment(const floam::OdometryResult& first);
  // Where it is tracked again, or not any more; stamp of the scan that shows it.
  void NoteTracking(bool is_lost, uint64_t sequence, int64_t stamp_ns);
  void Tell(const std::string& what) const;
  // What goes for the scan that was dealt with; mutex_ is held.
  void FillStatus(ScanAck* ack) const;
  void Hand(std::shared_ptr<const Submap> submap);
  void Cut(std::shared_ptr<const Submap> submap);
  // What was cut since the last call, and a checkpoint if one is due or something was cut.
  std::deque<Stretch> TakeFinished(uint64_t sequence, uint64_t checkpoint_after);
  absl::Status Persist();  // Offers every unpersisted stretch, in order.
  void Send(const ScanAck& ack);

  const SessionRecord record_;
  const floam::SensorModel sensor_;
  const Options options_;
  const WorkerHooks hooks_;
  Executor* const executor_;

  // Touched only by the running task, or by Finish when none runs and none can start.
  std::unique_ptr<SessionState> state_;
  std::deque<Stretch> finished_;  // Cut while the scan at hand is dealt with.
  // Segment and index: submaps below this were stored before it resumed.
  std::pair<uint32_t, uint32_t> stored_until_ = {1, 0};
  uint64_t checkpoint_sequence_ = 0;  // Of the last checkpoint that was made.
  bool checkpoint_due_ = false;       // A segment has begun.

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
  std::optional<Pose> T_odom_last_;  // In the segment that it is in.
};

}  // namespace isthmus::ingest
