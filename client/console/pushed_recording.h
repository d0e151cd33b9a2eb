// The note in a spool's folder of a recording that is whole in a session. The spool itself is empty
// by then, and would take the same recording for a new one.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>
#include <string>

#include "client/console/push_scans.h"
#include "client/console/recording_options.h"
#include "client/library/client.h"
#include "client/readers/recording.h"
#include "core/records/session_status.h"

namespace isthmus::cli {

// A checksum over the scans of a recording, in their order: their times and points.
class RecordingSum {
 public:
  void Add(const readers::RecordedScan& scan);
  uint64_t scans() const { return scans_; }
  std::string text() const;

 private:
  uint64_t scans_ = 0;
  uint32_t sum_ = 0;
};

// Notes, on the disk on return, that the recording is in the session, which may be finished after
// that alone. Errors are io::FileError's.
absl::Status NotePushed(const std::string& spool, const RecordingSum& recording,
                        const SessionStatus& session);

// The session that was finished with all of this robot's recording, as the note in the spool says
// and the server confirms; nothing where there is none. Cancelled once the push is stopped: it must
// not begin a session then.
absl::StatusOr<std::optional<SessionStatus>> FindPushed(client::Client& client,
                                                        const RobotScans& robot,
                                                        const std::string& spool,
                                                        const PushControl& control);

// The server is out of reach, or hangs.
bool IsAway(const absl::Status& status);

// As Client::GetSession, but waits for a server that is away. Cancelled once the
// push is stopped.
absl::StatusOr<SessionStatus> AwaitSession(client::Client& client, const SessionId& id,
                                           const PushControl& control);

}  // namespace isthmus::cli
