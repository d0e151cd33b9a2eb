// The way in of one robot's scans: order, duplicates, back-pressure, odometry, submaps, hand-over
// to the store.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/clock.h"
#include "core/concurrency/executor.h"
#include "core/concurrency/mutex.h"
#include "core/map/session.h"
#include "core/map/submap.h"
#include "core/map/trajectory.h"
#include "core/records/server_load.h"
#include "core/scan_upload.h"
#include "core/stage_observer.h"
#include "floam/odometry.h"
#include "floam/odometry_options.h"
#include "floam/submap_builder.h"
#include "server/ingest/odometry_checkpoint_state.h"
#include "server/ingest/pace.h"
#include "server/ingest/queue_room.h"
#include "server/ingest/rate_limit.h"
#include "server/ingest/scan_queue.h"
#include "server/ingest/scan_times.h"
#include "server/ingest/worker_records.h"

namespace isthmus::ingest {

// The fate of a scan, and the text of its ack:
//   sequence dealt with before        duplicate; nothing happens
//   stamp up to 1 s before the last   rejected as out of order; nothing happens
//   newer ones came while it waited   skipped, in a session that keeps the newest; nothing happens
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
// is thinner, or, where that segment has none, in a new one, and says so in WorkerStatus. The map
// in which a kidnapped robot is looked for is made from the stored submaps: where some were retired
// since, a search may end otherwise than it would have.
//
// A robot does not wait for the disk: a scan is acknowledged before what it completed is stored,
// beside the scans that follow, and an ack of no scan then says what is durable. Where storing is
// a whole submap behind, the session waits for it.
//
// If something is thrown while a scan is dealt with (no memory, for one), that scan is rejected and
// what was under way, the unfinished submap with it, is let go of: it may be half done. The session
// goes on in a new segment, and says so.
//
// Until its first scan a session that is new is small; its odometry is made then.
//
// Thread safe. Runs at most one task at a time on the executor, which must outlive it, in a lane of
// its own: computing time is shared fairly among sessions, and what comes faster than it was
// measured (see Pace) has a smaller share.
class SessionWorker : public std::enable_shared_from_this<SessionWorker> {
 public:
  struct Options {
    size_t queue = 16;                      // Scans that may wait.
    size_t queue_bytes = size_t{64} << 20;  // Bytes of them, encoded; a larger scan waits alone.
    // Points of a scan at most: a larger one is rejected before it is decoded.
    uint64_t max_points = 1'000'000;
    // Scans a second beyond which the session waits, or skips; 0: no limit.
    double max_rate_hz = 0;
    floam::OdometryOptions odometry;
    floam::SubmapOptions submap;
    uint64_t checkpoint_scans = 200;  // A checkpoint at least after so many.
    // Shared by all sessions; null: no bound but this session's.
    std::shared_ptr<QueueRoom> room = nullptr;
    // Stores finished submaps and checkpoints; must outlive the worker. Null: the task of a scan
    // stores what it completed, before its ack.
    Executor* storing = nullptr;
    // A steady clock, nanoseconds, for the pace of scans; null: the machine's.
    std::function<int64_t()> now_ns = nullptr;
    StageObserver* observer = nullptr;      // May be null.
    const Clock* clock = &Clock::System();  // For the times that Load tells.
  };

  static std::shared_ptr<SessionWorker> Create(const SessionRecord& record,
                                               const floam::SensorModel& sensor,
                                               const Options& options, WorkerHooks hooks,
                                               Executor* executor, const ResumePoint& resume);

  // Queues a scan. While the queue is full, in number or bytes, it waits, or skips the oldest that
  // waits, as the session's record says. If not `waits` it returns false, and the scan as it was,
  // where it would wait or the session is beyond the limit on its rate. OutOfRange when the
  // sequence leaves a gap, InvalidArgument for sequence 0, Unavailable once stopped,
  // ResourceExhausted while finished submaps and checkpoints cannot be stored (each call tries once
  // more).
  absl::StatusOr<bool> Admit(ScanUpload* scan, bool waits);
  absl::Status Submit(ScanUpload scan) { return Admit(&scan, true).status(); }

  // Sets the sink of acks from now on. When it returns, the earlier sink is not called any more.
  void SetAckSink(AckSink sink);

  // Waits for queued scans, then cuts and persists the unfinished submap, with a checkpoint. Scans
  // submitted meanwhile are refused with Unavailable. Returns what persist said. Idempotent.
  absl::Status Finish();
  // Offers what could not be stored once more, and tells the robot if more is durable then. Returns
  // what persist said; OK when nothing waits.
  absl::Status RetryStoring();
  // Forgets queued scans, which are not acknowledged, and takes no more; does not wait for the one
  // in work. Acknowledged scans are persisted by Finish, which is to follow.
  void StopTaking();
  // Forgets queued scans and waits for the one in work; nothing more is persisted or acknowledged.
  void Abandon();

  WorkerStatus Status() const;
  // Status().last_sequence, without the rest, which is long.
  uint64_t last_sequence() const;
  // The scans that wait, and the progress of all its scans; nothing about stored data. Costs next
  // to nothing and waits for nobody's work.
  SessionLoad Load() const;
  const RobotId& robot() const { return record_.robot; }

 private:
  SessionWorker(const SessionRecord& record, const floam::SensorModel& sensor,
                const Options& options, WorkerHooks hooks, Executor* executor,
                const ResumePoint& resume);

  void Resume(const ResumePoint& resume) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void MakeState(uint32_t segment, uint32_t first_index);
  // Has the odometry remember the submaps of its segment; appends their points near the last pose,
  // odom frame, to `around` if it is not null.
  void RememberSubmaps(const ResumePoint& resume, Cloud* around)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void FollowPose(const TrajectoryEntry& entry, uint32_t segment)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // For sessions without a checkpoint, or without a usable one.
  void ResumeFromSubmaps(const ResumePoint& resume) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool KeepsNewest() const { return record_.when_behind == WhenBehind::kKeepNewest; }
  // Says of one that is too large why it is refused.
  WaitingScan Examine(ScanUpload scan) const;
  // Error while finished submaps and checkpoints cannot be stored; tries once more.
  absl::Status CheckStoring();
  // Waits, or skips, until the scan may be queued; false where it would wait and must not.
  // Unavailable once stopped.
  absl::StatusOr<bool> MakeRoom(const WaitingScan& scan, bool waits)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // True if the scan took its part of what sessions share; one that is skipped takes it always.
  bool TakeSharedRoom(WaitingScan* scan) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool IsFull(size_t more_bytes) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Enqueue(WaitingScan scan) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  size_t ClearQueue() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status ClosedError() const;
  // Executor task: deals with one scan and those skipped before it, posts itself again while there
  // are more.
  void RunOne();
  // False where none waits.
  bool TakeScan(WaitingScan* scan);
  // The ack says what is known, even after an exception. True if something that the scan completed
  // is still to be stored.
  bool HandleScan(const WaitingScan& scan, ScanAck* ack);
  void SkipScan(ScanAck* ack) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // True if the scan's ack is to wait until what it completed is stored.
  bool StoresFirst() const { return options_.storing == nullptr || checkpoint_due_; }
  bool Cut(uint64_t sequence);  // True if there was something to be stored.
  // After the ack of that scan. True if a task stores what waits, and then says that the scan is
  // done.
  bool PersistAsync(uint64_t sequence);
  void Store();  // The task of PersistAsync.
  // After something was thrown: the state is not used any more.
  void MarkBroken(const absl::Status& why, ScanAck* ack);
  void RestartSegment();
  void ProcessScan(const WaitingScan& scan, ScanAck* ack);
  absl::StatusOr<floam::OdometryResult> TrackScan(const WaitingScan& scan, int64_t time_ns);
  absl::StatusOr<Scan> DecodeScan(const ScanUpload& upload);
  void RejectScan(const ScanUpload& scan, const absl::Status& why, ScanAck* ack);
  void TakeResult(const floam::OdometryResult& result, ScanAck* ack);
  void BeginSegment(const floam::OdometryResult& first);
  // Notes that the robot is tracked again, or lost; stamp of the scan that shows it.
  void NoteTracking(bool is_lost, uint64_t sequence, int64_t stamp_ns);
  void Report(EventKind kind, const std::string& what) const;
  // Fills in the status after the scan that was dealt with.
  void FillStatus(ScanAck* ack) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void FlushSubmap() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void HandOverSubmap(std::shared_ptr<const Submap> submap);
  void FinishSubmap(std::shared_ptr<const Submap> submap);
  // The submaps cut since the last call, and a checkpoint if one is due or something was cut.
  std::deque<FinishedSubmap> TakeFinished(uint64_t sequence, uint64_t checkpoint_after);
  absl::Status PersistFinished();  // Offers every submap that is not stored yet, in order.
  void SendAck(ScanAck ack);
  void NoteAcknowledged(const WaitingScan& scan) ABSL_LOCKS_EXCLUDED(mutex_);
  // Tells the observer, if there is one.
  void TellAcknowledged(const ScanUpload& scan, ScanOutcome outcome) const;
  // Lets go of the times of scans that are durable now; likewise.
  void ForgetTimes() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const SessionRecord record_;
  const floam::SensorModel sensor_;
  const Options options_;
  const WorkerHooks hooks_;
  Executor* const executor_;
  const std::shared_ptr<Executor::Lane> lane_ = Executor::MakeLane();
  const std::shared_ptr<Executor::Lane> storing_lane_ = Executor::MakeLane();

  // Touched only by the running task, or by Finish when none runs and none can start. Null in a new
  // session until its first scan.
  std::unique_ptr<OdometryCheckpointState> state_;
  std::deque<FinishedSubmap> finished_;  // Cut while the scan at hand is dealt with.
  // Segment and index: submaps below this were stored before it resumed.
  std::pair<uint32_t, uint32_t> stored_until_ = {1, 0};
  uint64_t checkpoint_sequence_ = 0;  // Scan of the last checkpoint that was made.
  bool checkpoint_due_ = false;       // A segment has begun.
  bool is_broken_ = false;            // state_ may be half updated.

  Mutex sink_mutex_;  // Held while an ack is sent.
  AckSink sink_ ABSL_GUARDED_BY(sink_mutex_);
  uint64_t durable_told_ ABSL_GUARDED_BY(sink_mutex_) = 0;  // It never shrinks.

  Mutex persist_mutex_;  // Serialises PersistFinished.
  mutable Mutex mutex_ ABSL_ACQUIRED_AFTER(persist_mutex_);
  CondVar changed_;
  std::deque<FinishedSubmap> unpersisted_ ABSL_GUARDED_BY(mutex_);
  bool storing_fails_ ABSL_GUARDED_BY(mutex_) = false;  // It did, the last time.
  ScanQueue queue_ ABSL_GUARDED_BY(mutex_);
  Pace pace_ ABSL_GUARDED_BY(mutex_);
  RateLimit rate_ ABSL_GUARDED_BY(mutex_);
  uint64_t last_submitted_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t acknowledged_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t received_ns_ ABSL_GUARDED_BY(mutex_) = 0;   // When the newest scan came.
  int64_t ack_delay_ns_ ABSL_GUARDED_BY(mutex_) = 0;  // Delay of the newest acknowledged scan.
  ScanTimes times_ ABSL_GUARDED_BY(mutex_);           // Times of scans that are not durable yet.
  bool running_ ABSL_GUARDED_BY(mutex_) = false;      // A task is posted or at work.
  bool storing_posted_ ABSL_GUARDED_BY(mutex_) =
      false;  // A task of options_.storing has yet to run.
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  WorkerStatus status_ ABSL_GUARDED_BY(mutex_);
  double odometry_ms_sum_ ABSL_GUARDED_BY(mutex_) = 0;
  // In the segment that it is in.
  std::optional<StampedPose> newest_ ABSL_GUARDED_BY(mutex_);  // T_odom_sensor that is known.
  uint32_t newest_segment_ ABSL_GUARDED_BY(mutex_) = 1;        // The segment of that odom.
};

}  // namespace isthmus::ingest
