// Log lines about calls that failed, which quote the clients' input.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include "core/clock.h"
#include "core/concurrency/mutex.h"
#include "server/rpc/ended_call.h"

namespace isthmus::server {

// One line per call, a few a second at most, the same of the same caller once a minute; what was
// left out is counted in the line that follows. Thread safe.
class FailedCallLog {
 public:
  using Write = std::function<void(const rpc::FailedCall& call, const std::string& line)>;

  // `write` must not call back. The clock must outlive it.
  explicit FailedCallLog(Write write, const Clock& clock = Clock::System())
      : write_(std::move(write)), clock_(clock) {}

  void Note(const rpc::FailedCall& call);

 private:
  // True if there is room for one more line now, which it takes.
  bool TakeTurn(int64_t now_ns) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // True if the same was said in the last minute.
  bool IsSaid(const std::string& line, int64_t now_ns) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const Write write_;
  const Clock& clock_;
  Mutex mutex_;
  bool started_ ABSL_GUARDED_BY(mutex_) = false;
  int64_t refilled_ns_ ABSL_GUARDED_BY(mutex_) = 0;
  double lines_ ABSL_GUARDED_BY(mutex_) = 0;  // Lines that may be written at once.
  // The time of each of the last lines, by its caller and text.
  std::map<std::string, int64_t> said_ns_ ABSL_GUARDED_BY(mutex_);
  uint64_t left_out_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace isthmus::server
