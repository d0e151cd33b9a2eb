// Exponential backoff: the wait before the next attempt.
#pragma once

#include <optional>
#include <random>

#include "client/library/options.h"

namespace isthmus::client {

// Exponential back-off with jitter. Not thread safe.
class Backoff {
 public:
  // An attempt goes round so many `ways` to a server, one after the other without waiting.
  explicit Backoff(const BackoffOptions& options, int ways = 1);

  // Seconds to wait after a failure; empty when max_attempts have failed.
  std::optional<double> Next();
  // After a success: the next failure is the first again.
  void Reset() { failures_ = 0; }

 private:
  const BackoffOptions options_;
  const int ways_;
  std::mt19937_64 random_;
  int failures_ = 0;  // Failures of all ways.
};

}  // namespace isthmus::client
