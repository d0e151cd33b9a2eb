// Exponential backoff: the wait before the next attempt.
#pragma once

#include <optional>
#include <random>

#include "client/library/options.h"

namespace isthmus::client {

// Exponential back-off with jitter. Not thread safe.
class Backoff {
 public:
  explicit Backoff(const BackoffOptions& options);

  // Seconds to wait after a failed attempt; empty when max_attempts have failed.
  std::optional<double> Next();
  // After a success: the next failure is the first again.
  void Reset() { failures_ = 0; }

 private:
  const BackoffOptions options_;
  std::mt19937_64 random_;
  int failures_ = 0;
};

}  // namespace isthmus::client
