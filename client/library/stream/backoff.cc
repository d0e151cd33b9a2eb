#include "client/library/stream/backoff.h"

#include <algorithm>
#include <cmath>

namespace isthmus::client {

Backoff::Backoff(const BackoffOptions& options)
    : options_(options), random_(options.seed != 0 ? options.seed : std::random_device{}()) {}

std::optional<double> Backoff::Next() {
  if (++failures_ >= options_.max_attempts) return std::nullopt;
  const double full = std::min(options_.max_delay_s,
                               options_.first_delay_s * std::pow(options_.factor, failures_ - 1));
  return full * (1 - options_.jitter * std::uniform_real_distribution<double>(0, 1)(random_));
}

}  // namespace isthmus::client
