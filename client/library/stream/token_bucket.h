// So many bytes per second, and no more. Private to the library.
#pragma once

#include <algorithm>

namespace isthmus::client {

// Lets through what it has tokens for; one that is larger than all it can hold waits for as long as
// its size asks, so that the rate is kept whatever the sizes. Not thread safe.
class TokenBucket {
 public:
  // 0: no limit. Holds what comes in within one second.
  explicit TokenBucket(double bytes_per_s) : rate_(bytes_per_s), tokens_(bytes_per_s) {}

  // When `now` is early: the instant from which the bytes may go. Else `now`, and they are taken.
  double TakeTokens(double bytes, double now) {
    if (rate_ <= 0) return now;
    if (started_) tokens_ = std::min(rate_, tokens_ + (now - filled_) * rate_);
    started_ = true;
    filled_ = now;
    // Goes into debt, which the next ones wait for.
    if (tokens_ < 0) return now + -tokens_ / rate_;
    tokens_ -= bytes;
    return now;
  }

 private:
  const double rate_;
  double tokens_;
  double filled_ = 0;
  bool started_ = false;
};

}  // namespace isthmus::client
