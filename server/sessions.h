// The sessions of robots, and the scans and submaps that come in through them.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <vector>

#include "core/map/submap.h"
#include "core/records/event.h"
#include "core/records/session_status.h"
#include "core/scan_upload.h"

namespace isthmus::server {

// Thread safe. A later segment of a session is opened, finished and deleted with the session; to
// ask that of it alone is FailedPrecondition. A change is asked for `by` somebody, for the event
// log.
class Sessions {
 public:
  virtual ~Sessions() = default;

  // InvalidArgument for a robot name that is empty, longer than 64 or not of [A-Za-z0-9_.-], an
  // unknown sensor or an unknown odometry. This, SubmitScan and AddSubmap: ResourceExhausted while
  // the robot is above its quota (RetentionOptions); the message says what to do.
  virtual absl::StatusOr<SessionStatus> Create(const SessionRequest& request,
                                               const Actor& by = Actor()) = 0;
  virtual absl::StatusOr<SessionStatus> Get(const SessionId& session) const = 0;
  virtual std::vector<SessionStatus> List() const = 0;
  // Waits for queued scans, cuts and stores the last submap. Finishing twice is no error.
  virtual absl::StatusOr<SessionStatus> Finish(const SessionId& session,
                                               const Actor& by = Actor()) = 0;
  // The session and all that came of it leave the map.
  virtual absl::Status Delete(const SessionId& session, const Actor& by = Actor()) = 0;

  // Sets the sink of the session's acks from now on; replaces an earlier sink. A null sink drops
  // them. NotFound for an unknown session, FailedPrecondition for a finished one.
  virtual absl::Status SetAckSink(const SessionId& session, AckSink sink) = 0;
  // Queues a scan; its ack follows. Waits while the session's queue is full, so that the robot is
  // slowed down and nothing is dropped. Unavailable while shutting down. OutOfRange, and nothing
  // queued, when `sequence` leaves a gap; the message names the expected one.
  virtual absl::Status SubmitScan(const SessionId& session, ScanUpload scan) = 0;
  // The same without waiting: false, and the scan as it was, where there is no room or the session
  // is beyond the limit on its rate. Room comes back with acks of the session and, where sessions
  // share it, of others, and that of the rate with time.
  virtual absl::StatusOr<bool> OfferScan(const SessionId& session, ScanUpload* scan) = 0;
  // A finished submap from a robot with its own SLAM; durable on return. Its session must have no
  // scans. The submap's id.index must be the next of the session (OutOfRange otherwise), or repeat
  // a stored one with equal content (OK, no effect) or not (AlreadyExists).
  virtual absl::StatusOr<SubmapInfo> AddSubmap(Submap submap) = 0;
};

}  // namespace isthmus::server
