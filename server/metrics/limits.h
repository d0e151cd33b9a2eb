// Judged limits of metrics.
#pragma once

#include <cstddef>

namespace isthmus::metrics {

// Robots of a site that have series of their own, a dozen each; the rest share one name. A fleet
// that people look at robot by robot is smaller, and Prometheus keeps a few kB for each series.
inline constexpr int kNamedRobots = 100;

// Threads that answer scrapes: one that is slow to read does not keep the other out.
inline constexpr int kHttpThreads = 2;

// Milliseconds that a client may take to ask, or to read on. Prometheus gives up after 10 s itself
// by default.
inline constexpr int kHttpTimeoutMs = 10'000;

}  // namespace isthmus::metrics
