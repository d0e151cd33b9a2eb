#include "client/library/stream/backoff.h"

#include <algorithm>
#include <cmath>

namespace isthmus::client {

Backoff::Backoff(const BackoffOptions& options, int ways)
    : options_(options),
      ways_(std::max(ways, 1)),
      random_(options.seed != 0 ? options.seed : std::random_device{}()) {}

std::optional<double> Backoff::Next() {
  if (++failures_ % ways_ != 0) return 0;
  const int rounds = failures_ / ways_;
  if (rounds >= options_.max_attempts) return std::nullopt;
  const double full = std::min(options_.max_delay_s,
                               options_.first_delay_s * std::pow(options_.factor, rounds - 1));
  return full * (1 - options_.jitter * std::uniform_real_distribution<double>(0, 1)(random_));
}

}  // namespace isthmus::client
