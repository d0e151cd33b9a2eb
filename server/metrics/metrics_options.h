// The settings of the metrics.
#pragma once

#include <absl/status/status.h>

#include <string>

#include "server/metrics/limits.h"

namespace isthmus::metrics {

struct MetricsOptions {
  std::string listen = {};  // "host:port", port 0 takes a free one; empty: no metrics.
  // True if an address that other machines reach may be served, in plain text and to anybody.
  bool insecure = false;
  int robots = kNamedRobots;  // Robots of a site that have series of their own.
};

// Errors for a person to put right before a start: InvalidArgument where the address is none of
// TCP, FailedPrecondition where others than this machine reach it and `insecure` does not say that
// they may.
absl::Status CheckListening(const MetricsOptions& options);

}  // namespace isthmus::metrics
