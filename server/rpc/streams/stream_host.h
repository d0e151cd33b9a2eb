// The things that all streams of a server share: the gate, threads, timers, memory, and a list of
// live streams.
#pragma once

#include <chrono>
#include <cstddef>
#include <set>

#include "core/concurrency/executor.h"
#include "core/concurrency/mutex.h"
#include "server/rpc/gate.h"
#include "server/rpc/streams/byte_budget.h"
#include "server/rpc/streams/limits.h"
#include "server/rpc/streams/watchdog.h"

namespace isthmus::rpc {

struct StreamOptions {
  std::chrono::milliseconds first_message = kFirstMessage;  // From the beginning of a stream on.
  std::chrono::milliseconds progress = kProgress;  // For an upload, and for a client that reads.
  size_t all_bytes = kAllStreamBytes;              // Scans that all streams hold.
};

// A stream that can be asked to end.
class StoppableStream {
 public:
  virtual ~StoppableStream() = default;
  // Everything acknowledged stays so; never waits.
  virtual void Stop() = 0;
};

// Thread safe. The gate must outlive it, and it the gRPC server: streams are in its list until gRPC
// is done with them.
class StreamHost {
 public:
  StreamHost(Gate* its_gate, const StreamOptions& its_options)
      : gate(*its_gate), options(its_options), budget(its_options.all_bytes) {}

  Gate& gate;
  const StreamOptions options;
  Watchdog watchdog;
  ByteBudget budget;
  // Tasks that wait for the disk at most, that decode and store, that compute, that read events.
  Executor scans{kScanThreads}, uploads{kUploadThreads}, localisers{kLocaliseThreads},
      watches{kWatchThreads};

  void Enter(StoppableStream* stream);
  void Leave(StoppableStream* stream);
  // Asks all to end, and those that enter from now on.
  void StopAll();

 private:
  Mutex mutex_;
  std::set<StoppableStream*> streams_ ABSL_GUARDED_BY(mutex_);
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace isthmus::rpc
