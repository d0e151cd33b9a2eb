// The interval at which work on one submap checks whether to go on.
#pragma once

#include <cstddef>
#include <functional>

#include "server/composition/limits.h"

namespace isthmus::composition {

// Asked every few milliseconds; false ends the work, whose result is lost.
using KeepOn = std::function<bool()>;

// True if to end at the i-th point. What has fewer points than are looked at between two questions
// is never ended: it is done sooner than it would be begun again.
inline bool EndsAt(size_t i, const KeepOn& keep_on) {
  return i % kPointsAtOnce == kPointsAtOnce - 1 && !keep_on();
}

}  // namespace isthmus::composition
