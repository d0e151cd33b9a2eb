// The numbers of calls of each kind that run at a time, in all and of one caller.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/time/time.h>

#include <cstddef>
#include <map>
#include <string>
#include <utility>

#include "core/concurrency/mutex.h"
#include "core/records/server_status.h"
#include "server/access/methods.h"
#include "server/rpc/streams/limits.h"

namespace isthmus::rpc {

struct CallLimitOptions {
  size_t streams = kStreams;
  size_t streams_per_caller = kStreamsPerCaller;
  // Queries, and as many lists; a quarter as many exports. One caller has half of each at most,
  // and at least one.
  size_t queries = kQueries;
};

// Thread safe; must outlive its tickets.
class CallLimits {
 public:
  using Kind = access::CallKind;

  // A call's place; gives it up when destroyed.
  class Ticket {
   public:
    Ticket(Ticket&& other) noexcept
        : limits_(std::exchange(other.limits_, nullptr)),
          kind_(other.kind_),
          caller_(std::move(other.caller_)) {}
    Ticket& operator=(Ticket&&) = delete;
    ~Ticket();

   private:
    friend class CallLimits;
    Ticket(CallLimits* limits, Kind kind, std::string caller)
        : limits_(limits), kind_(kind), caller_(std::move(caller)) {}
    CallLimits* limits_;
    Kind kind_;
    std::string caller_;
  };

  explicit CallLimits(const CallLimitOptions& options) : options_(options) {}

  // `caller` is whatever names who makes the call.
  // ResourceExhausted, saying when to come again (see convert::WithRetryAfter), beyond a limit;
  // Unavailable once stopped.
  absl::StatusOr<Ticket> Enter(Kind kind, const std::string& caller);

  RunningCallCounts Running() const;

  // From now on nobody enters.
  void Stop();
  // Waits until nobody is in, or until then; whether nobody is.
  bool WaitUntilIdle(absl::Time deadline);

 private:
  struct Most {
    size_t in_all, of_caller;
  };
  Most MostOf(Kind kind) const;
  void Leave(const Ticket& ticket);

  const CallLimitOptions options_;
  mutable Mutex mutex_;
  CondVar left_;
  std::map<Kind, size_t> calls_ ABSL_GUARDED_BY(mutex_);
  std::map<std::pair<Kind, std::string>, size_t> callers_ ABSL_GUARDED_BY(mutex_);
  size_t all_ ABSL_GUARDED_BY(mutex_) = 0;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
};

// A peer as gRPC names it ("ipv4:10.0.0.7:4711") without its port: all connections of a machine.
std::string MachineOf(const std::string& peer);

}  // namespace isthmus::rpc
