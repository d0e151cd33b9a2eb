// Judged limits of metrics.
#pragma once

#include <chrono>
#include <cstddef>

namespace isthmus::metrics {

// Robots of a site that have series of their own, a dozen each; the rest share one name. A fleet
// that people look at robot by robot is smaller, and Prometheus keeps a few kB for each series.
inline constexpr int kNamedRobots = 100;

// Connections at a time, a thread each, also connections on which half a request came. As many such
// clients keep the others out for the time below.
inline constexpr size_t kHttpConnections = 8;

// The time that a client may take to ask, or to read on: it asks in one packet, of one machine or
// its network.
inline constexpr std::chrono::milliseconds kHttpTime{2'000};

}  // namespace isthmus::metrics
