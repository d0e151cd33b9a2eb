// Options for keeping scans on the robot's disk.
#pragma once

#include <cstdint>

namespace isthmus::client {

// The behaviour of Push when the spool is as large as it may be, or its disk is full.
enum class WhenFull {
  // Waits until there is room: nothing is lost as long as the source of the scans waits, too. For
  // recordings.
  kWait,
  // Returns ResourceExhausted; that scan is lost unless the caller keeps it.
  kRefuse,
  // Gives up the oldest scans, some dozen at a time, for the newest. Their numbers are used up: the
  // server is told that these scans are lost. What Push returned OK for may be lost then, but never
  // for want of a link that comes back in time. For robots whose present matters most.
  kDropOldest,
};

// The treatment of scans of a session that cannot go on: it was finished or deleted by somebody
// else, or the server was restored from a backup that is older than the oldest scan kept.
enum class IfSessionIsGone {
  // The stream ends with FailedPrecondition, saying so. The spool is kept.
  kStop,
  // They go into a new session of the same robot, from the first that the server lacks.
  kNewSession,
};

struct SpoolOptions {
  // The limit on all files together. When it is reached see WhenFull. It, and the disk, should hold
  // an outage's scans and 200 more at least: so many may wait for the server to make them durable.
  uint64_t max_bytes = uint64_t{8} << 30;
  WhenFull when_full = WhenFull::kWait;
  // 0: when Push returns the scan is on the disk, and survives a power cut; takes one fsync, some
  // milliseconds. Else: when Push returns it survives the death of the program, and is on the disk
  // so much later at most, if another one follows. Scans that are not on the disk are not sent.
  double sync_interval_s = 0;
  IfSessionIsGone if_session_is_gone = IfSessionIsGone::kStop;
  // The source gives the same scans again, in the same order, as a recording does, and Push gets
  // those behind SpoolState::last_sequence. Scans that a damaged spool lost and the server has then
  // take their own numbers again, and are kept, but not sent. Nothing is sent before the first Push
  // or Finish, so that who finds another recording's scans in the spool may leave them there. Else
  // (a sensor) new scans are numbered on behind those that the server has.
  bool is_replayed = false;

  // A link on which nothing moves for so long although it should is opened anew.
  double stall_timeout_s = 15;
  // Waiting between attempts, in place of ClientOptions::backoff: for ever. Short, so that the
  // robot is back within two seconds of the link.
  double retry_first_s = 0.1, retry_max_s = 1;
  // The time that a new link's first answer may take; more is given to a link that stands but is
  // slow.
  double attempt_timeout_s = 2;

  // The rate at which scans older than `live_s` are sent, so that an outage's back-fill leaves room
  // on the link; 0: no limit. Below the rate of the scans themselves it never ends.
  double backfill_bytes_per_s = 0;
  double live_s = 2;
  // Order is kept within a session, so new scans wait behind the back-fill. Not 0: when the server
  // is back and the oldest scan that it lacks is older than this, new scans go into a new session
  // of the robot, at once; the earlier one is filled up beside it, finished and removed. It has an
  // odom frame of its own, which the server joins with the earlier one where both saw the same.
  double prefer_live_after_s = 0;
};

}  // namespace isthmus::client
