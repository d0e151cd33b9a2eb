// The loop that pushes the scans of recordings into sessions, shared by `push`, `odometry` and
// `merge`.
#pragma once

#include <absl/status/statusor.h>

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "client/console/recording_options.h"
#include "client/library/client.h"
#include "core/concurrency/mutex.h"
#include "core/map/session.h"

namespace isthmus::cli {

struct PushOptions {
  // The choices of each robot's session but its robot, sensor and extrinsic, see RequestOf.
  SessionRequest session = {};
  std::optional<double> pace_hz = std::nullopt;  // Absent: as fast as the server takes them.
  double resolution_m = 0.002;                   // Quantisation; 0: every bit.
  bool finish = true;                            // Finish the sessions afterwards.
  // Robots are followed here and send submaps, see PushKeyframes; without a spool.
  bool keyframes = false;
  bool is_live = false;  // A sensor, which does not say the same again.
  // Folder of a spool: an earlier push that was cut off is gone on with. Of several robots each has
  // a folder in it, of its name. Empty: none.
  std::string spool = {};
  // Scans left in the spool go into a new session if their own cannot go on.
  bool new_session = false;
};

SessionRequest RequestOf(const RobotScans& robot, const PushOptions& options);

struct PushSummary {
  std::string robot, sensor;
  SessionId session;
  client::ScanStreamStats scans;
  uint64_t unreadable =
      0;                // Scans, or stretches, that could not be read; each was named on stderr.
  uint64_t before = 0;  // Scans that an earlier push with this spool had taken.
  double seconds = 0;   // Wall time.
  // Computing time of the odometry per processed scan; nothing without one.
  std::optional<double> mean_ms;
  std::optional<uint64_t> durable_sequence;  // Nothing where that was not told.
  std::optional<int> reconnects;             // Nothing where they are not counted.
  SessionStatus state;                       // The session's, at the end.
  bool has_state = false;                    // Its counts of scans and segments are known.
  std::vector<ScanAck> acks;
  std::string first_rejection;  // Its reason.
  std::vector<std::string> assumptions;
  bool is_interrupted = false;

  // Scans of the session that count, those of an earlier push among them.
  uint64_t used() const { return scans.processed + scans.duplicates + before; }
};

// Ends a push before its recordings do. Thread safe.
class PushControl {
 public:
  // No more scans are read; those that were are pushed. False if nothing is pushed yet.
  bool Stop();
  bool stopped() const;

  // While it lives, Stop gives this stream up: its spool keeps what the server lacks.
  class GivenUp {
   public:
    GivenUp(PushControl& control, client::ScanStream* stream);
    ~GivenUp();
    GivenUp(const GivenUp&) = delete;
    GivenUp& operator=(const GivenUp&) = delete;

   private:
    PushControl& control_;
    client::ScanStream* const stream_;
  };

  // While it lives, these robots' readers are interrupted by Stop.
  class Registration {
   public:
    Registration(PushControl& control, std::vector<RobotScans>* robots);
    ~Registration();
    Registration(const Registration&) = delete;
    Registration& operator=(const Registration&) = delete;

   private:
    PushControl& control_;
  };

 private:
  mutable Mutex mutex_;
  std::vector<RobotScans>* robots_ ABSL_GUARDED_BY(mutex_) = nullptr;
  std::set<client::ScanStream*> spooled_ ABSL_GUARDED_BY(mutex_);
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
};

// Opens a session for every robot and pushes its scans, all robots at the same time; with a spool
// it goes on behind the last one that was taken. A scan that cannot be read or used is reported on
// stderr and left out; the others go on. So is, at once, the beginning of a segment. Once stopped,
// sessions without a spool are finished as they are, and with one it ends at once. The error of one
// robot is returned when all have ended.
absl::StatusOr<std::vector<PushSummary>> PushRobots(client::Client& client,
                                                    std::vector<RobotScans> robots,
                                                    const PushOptions& options,
                                                    PushControl& control);

}  // namespace isthmus::cli
