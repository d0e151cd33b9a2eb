// One robot's scans on their way to the server.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/library/spool/spool_options.h"
#include "core/ids.h"
#include "core/point_payload.h"
#include "core/pose.h"
#include "core/records/session_status.h"
#include "core/scan.h"
#include "core/scan_upload.h"

namespace isthmus::client {

struct ScanStreamOptions {
  // Scans under way without acknowledgement. Without a spool Push waits when there are as many: for
  // a session that keeps the newest (WhenBehind) some dozens, so that the server may choose.
  size_t window = 16;
  // Without a spool scans are kept in memory until they are durable, to be sent again should the
  // server crash; of those that are acknowledged the oldest go once all take more than this.
  size_t spool_bytes = 256u << 20;
  // The folder in which scans are kept until they are durable at the server: a folder for this
  // robot alone. What Push returned OK for then survives this program, and is sent by the next one
  // that opens the folder. Empty: in memory.
  std::string spool_dir = {};
  SpoolOptions spool = {};  // With spool_dir.
  // Sends x, y, z rounded to this, compressed (0.001 to 0.005 is usual); 0: as they are. Payloads
  // that are compressed already are sent as they are.
  double resolution_m = 0;
  // Called once per scan, in order within a session, from a thread of the stream, one call at a
  // time. Must not call the stream. Scans that an earlier program pushed are among them unless it
  // had their acknowledgement, and maybe then.
  std::function<void(const ScanAck&)> on_ack = nullptr;
  // Told of events that are worth a line in a log: lost links, damage, changes of session.
  // Likewise.
  std::function<void(const std::string&)> on_event = nullptr;
};

struct ScanStreamStats {
  uint64_t pushed = 0, processed = 0, duplicates = 0, rejected = 0;
  uint64_t skipped = 0;  // By a server that was behind, see WhenBehind::kKeepNewest.
  uint64_t durable_sequence = 0;
  uint64_t sent_bytes = 0;  // Clouds, those sent again included.
  int reconnects = 0;
  uint64_t backlog = 0;      // Scans without acknowledgement, of earlier programs too.
  uint64_t spool_bytes = 0;  // On the disk, or in memory.
  // With a spool:
  uint64_t lost = 0;       // Damaged in the spool, or dropped from it.
  uint64_t set_aside = 0;  // Larger than the server takes: files in SPOOL/too-large.
};

// The state of a spool when it was opened.
struct SpoolState {
  std::string robot;   // Empty without a spool.
  std::string sensor;  // The session's.
  SessionId session;   // Empty while the server has not been asked for it.
  // The newest scan that was pushed; 0: none. A session that goes on behind scans that a damaged
  // spool lost: the server's newest.
  uint64_t last_sequence = 0;
  int64_t last_stamp_ns = 0;  // Its end.
  // With SpoolOptions::is_replayed, where scans that the server has are not kept here for certain,
  // as the spool is damaged: so many more it has than the spool (if negative, fewer).
  std::optional<int64_t> server_ahead = {};
  uint64_t server_sequence = 0;  // The newest of them.
};

// Thread safe, though scans of one robot come from one thread. When the link is lost it is opened
// again, with back-off, and whatever the server lacks is sent again: nothing is lost and nothing
// counts twice. Without a spool it gives up after backoff.max_attempts without any acknowledgement
// in between, and from then on every call returns that error; with a spool it never gives up,
// except where only a person can help (see IfSessionIsGone).
class ScanStream {
 public:
  // Gives up what is not acknowledged; call Finish first. With a spool nothing is given up: what
  // is left is sent by whoever opens the spool next.
  ~ScanStream();

  // Hands over a scan; stamp is the END of it. InvalidArgument for a payload that cannot be
  // compressed: it was not taken, and the stream goes on.
  //
  // Without a spool: waits while the window is full; the scan is lost with this program.
  // With one: OK means that the scan is in the spool, see SpoolOptions::sync_interval_s for how
  // safe. ResourceExhausted when the spool or its disk is full, as WhenFull says; Unavailable when
  // the disk fails: nothing of the scan stays then, and the next call may succeed.
  absl::Status Push(int64_t end_stamp_ns, PointPayload payload);
  absl::Status Push(const Scan& scan);  // Its sequence is not used: the stream counts.

  // Waits until every scan is acknowledged and closes the stream. The session stays open, see
  // Client::FinishSession. Idempotent.
  absl::Status Finish();
  // As Finish, then finishes the session (and those of an earlier program) and empties the spool:
  // all is durable. Returns the session.
  absl::StatusOr<SessionStatus> FinishSession();

  // Ends calls of Push, Finish and FinishSession that wait, and later ones, with Cancelled: for a
  // program that is to end though its server is gone. With a spool nothing is lost by it.
  void GiveUp();

  ScanStreamStats stats() const;
  // The state that an earlier program left; all empty without a spool.
  SpoolState resumed() const;
  // True for the newest scan that an earlier program left, as Push would write it; nothing
  // where that is not kept any more. To be asked before anything is pushed.
  std::optional<bool> IsNewest(int64_t end_stamp_ns, PointPayload payload) const;
  // The session of the scans that are pushed now; empty until the server has been asked for one.
  SessionId session() const;

  class Impl;  // Private to the library.
  explicit ScanStream(std::unique_ptr<Impl> impl);

 private:
  const std::unique_ptr<Impl> impl_;
};

}  // namespace isthmus::client
