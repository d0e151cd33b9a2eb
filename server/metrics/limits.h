// Judged limits of metrics.
#pragma once

#include <cstddef>

namespace isthmus::metrics {

// Robots of a site that have series of their own, a dozen each; the rest share one name. A fleet
// that people look at robot by robot is smaller, and Prometheus keeps a few kB for each series.
inline constexpr int kNamedRobots = 100;

// Threads that answer scrapes: CivetWeb's, each of one connection at a time, also of one on which
// half a request came. As many such clients keep the others out for the time below.
inline constexpr int kHttpThreads = 8;

// Milliseconds that a client may take to ask, or to read on: it asks in one packet, of one machine
// or its network.
inline constexpr int kHttpTimeoutMs = 2'000;

}  // namespace isthmus::metrics
