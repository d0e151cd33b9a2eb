// The ingest part of the pipeline: sessions, and the scans and submaps that come in through them.
#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/pipeline/pipeline_parts.h"
#include "server/sessions.h"

namespace isthmus::server {

// InvalidArgument if it is no name of a robot.
absl::Status CheckRobotName(const RobotId& robot);

// See Sessions for the promises, and Pipeline for a replica's. Thread safe.
class SessionManager : public Sessions {
 public:
  // `parts` must outlive it; their executor and retention are there before anything is asked.
  explicit SessionManager(PipelineParts* parts) : parts_(*parts) {}

  // Gives the sessions of the store that take scans their workers. Call once, before anything else.
  absl::Status Resume();

  absl::StatusOr<SessionStatus> Create(const SessionRequest& request, const Actor& by) override;
  absl::StatusOr<SessionStatus> Get(const SessionId& session) const override;
  std::vector<SessionStatus> List() const override;
  absl::StatusOr<SessionStatus> Finish(const SessionId& session, const Actor& by) override;
  absl::Status Delete(const SessionId& session, const Actor& by) override;
  // Delete by the retention thread, which need not be told. `why`, for the revision's cause, is
  // empty where someone asked for it.
  absl::Status Remove(const SessionId& session, const std::string& why, const Actor& by);

  absl::Status SetAckSink(const SessionId& session, AckSink sink) override;
  absl::Status SubmitScan(const SessionId& session, ScanUpload scan) override {
    return AdmitScan(session, &scan, true).status();
  }
  absl::StatusOr<bool> OfferScan(const SessionId& session, ScanUpload* scan) override {
    return AdmitScan(session, scan, false);
  }
  absl::StatusOr<SubmapInfo> AddSubmap(Submap submap) override;

 private:
  using Worker = ingest::SessionWorkers::Worker;

  absl::StatusOr<bool> AdmitScan(const SessionId& session, ScanUpload* scan, bool waits);
  // The session that was opened for the same robot and request id.
  std::optional<SessionStatus> FindRequested(const SessionRecord& record) const;
  // Finishes the session that has been without data for longest, if as many are open as may be.
  void MakeRoom();
  // ResourceExhausted, saying what to do, where no more may be opened.
  absl::Status CheckOpenSessions(const RobotId& robot) const;
  // No other session has it, nor is a robot named so.
  SessionId NextId(const RobotId& robot, int* number) const;
  // Numbers of sessions that are there, or that the event log knows as deleted: nor are these given
  // again. A holder of submaps of one (a worker, a replica) takes another's for them.
  void NoteNumbers(const MapView& view);
  void NoteNumber(const RobotId& robot, const SessionId& session)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(parts_.membership);
  absl::StatusOr<Worker> MakeWorker(const SessionRecord& record, const ingest::ResumePoint& resume);
  ingest::WorkerHooks HooksOf(const SessionId& session);
  // Goes on from where the session, its first segment, is stored to be.
  absl::Status Resume(const SessionView& session);
  // If making it throws, its checkpoint is treated as damaged.
  absl::StatusOr<Worker> MakeWorkerWithOrWithoutCheckpoint(const SessionRecord& record,
                                                           ingest::ResumePoint* resume);
  // A worker that goes on from the session's stored state, that of its first segment.
  absl::StatusOr<Worker> ResumeWorker(const SessionView& session);
  absl::StatusOr<ingest::StoredSegment> ReadSegment(const SessionView& session);
  // Absent where there is none.
  absl::StatusOr<std::optional<SessionCheckpoint>> ReadCheckpoint(const SessionId& session) const;
  // The worker of an active session that takes scans.
  absl::StatusOr<Worker> FindWorker(const SessionId& session) const;

  SessionStatus StatusOf(const MapView& view, const SessionView& session) const;
  // Fills in the status of a session as a whole, reported in its first segment.
  void FillStreamStatus(const MapView& view, const SessionView& session,
                        SessionStatus* status) const;

  // OK if the session takes uploads and the index leaves no gap; else an error that says what to
  // do.
  absl::Status CheckUpload(const SessionView& session, const SubmapId& submap) const;
  // A submap whose index was taken in before.
  absl::StatusOr<SubmapInfo> RepeatUpload(const SubmapInfo* existing, const Submap& repeated);

  PipelineParts& parts_;
  // The numbers given to the robots' sessions. A deleted session's number is not given again: the
  // slow loop may still be at work on its map.
  std::map<RobotId, int> last_numbers_ ABSL_GUARDED_BY(parts_.membership);
};

// NotFound, or FailedPrecondition for a later segment of a session. Points into the view.
absl::StatusOr<const SessionView*> FindOpened(const MapView& view, const SessionId& session);
absl::Status UnknownSession(const SessionId& session);

}  // namespace isthmus::server
