// The scans of one session until they are durable at the server, on disk or in memory. Private to
// the library.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/library/spool/spool_identity.h"

namespace isthmus::client {

// Sequences count without gaps, here and at the server. A scan that got lost all the same (a
// damaged record, a dropped file) leaves its number, so that it can be told to the server.
//
// Thread safe. One scan is written at a time.
class SessionSpool {
 public:
  virtual ~SessionSpool() = default;

  virtual SpoolIdentity identity() const = 0;
  // As durable as the scans on return.
  virtual absl::Status SetIdentity(const SpoolIdentity& identity) = 0;

  // Writes a scan behind the last and returns its sequence. `now_s` is when, on the caller's clock.
  // Nothing of the scan stays after an error, and the next call tries anew.
  virtual absl::StatusOr<uint64_t> Append(int64_t end_stamp_ns, std::string payload,
                                          double now_s) = 0;
  // Makes safe all that was written.
  virtual absl::Status Sync(double now_s) = 0;

  // The server has used other numbers than the spool expected: scans above `from`, none of which
  // was sent, are numbered on from `sequence`. Aborted where that cannot be.
  virtual absl::Status Skip(uint64_t from, uint64_t sequence) = 0;

  // DataLoss when it is damaged, NotFound when it is not kept.
  virtual absl::StatusOr<std::string> Read(uint64_t sequence) const = 0;

  struct Entry {
    uint64_t bytes = 0;
    double appended_s = 0;  // On the caller's clock; from an earlier program: minus infinity.
  };
  // Nothing when the scan is lost or not kept.
  virtual std::optional<Entry> Find(uint64_t sequence) const = 0;
  // The stamp of the newest known scan before `sequence`; 0: none.
  virtual int64_t StampBefore(uint64_t sequence) const = 0;

  virtual uint64_t first() const = 0;    // The lowest kept; those before were released or dropped.
  virtual uint64_t safe() const = 0;     // Up to here they may be sent.
  virtual uint64_t written() const = 0;  // The newest scan.
  virtual uint64_t bytes() const = 0;    // The room that all of it takes.

  // No scan up to `durable` is needed any more, and none up to `acked` unless the server crashes.
  virtual void Release(uint64_t durable, uint64_t acked) = 0;
  // Makes room whatever is lost by it. False when nothing can be dropped.
  virtual bool DropOldest() { return false; }
  // Forgets all; nothing else may be called afterwards.
  virtual absl::Status Remove() = 0;

  // Descriptions of damage for a person; each is returned once.
  virtual std::vector<std::string> TakeNotes() { return {}; }
};

}  // namespace isthmus::client
