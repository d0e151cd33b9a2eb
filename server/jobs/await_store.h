// Reading from a store that may be away for a while.
#pragma once

#include <absl/status/status.h>

#include <functional>
#include <stop_token>

#include "core/stopwatch.h"

namespace isthmus::server {

// Thrown out of work that is to end.
struct Stopped {};

// Waits a moment for the store, which was asked in vain since then; false where there is no sense
// in it. Null: there never is.
using WaitForStore = std::function<bool(const Stopwatch& since)>;

// The result of `read`, which is made again while it is Unavailable and `wait` waits. Throws
// Stopped once `stop` is requested.
template <typename Read>
auto AwaitStore(const Read& read, const WaitForStore& wait, const std::stop_token& stop)
    -> decltype(read()) {
  const Stopwatch since;
  while (true) {
    auto result = read();
    if (stop.stop_requested()) throw Stopped();
    if (!absl::IsUnavailable(result.status()) || wait == nullptr || !wait(since)) return result;
  }
}

}  // namespace isthmus::server
