// The settings of the metrics.
#pragma once

#include <absl/status/status.h>

#include <string>

#include "server/metrics/limits.h"

namespace isthmus::metrics {

struct MetricsOptions {
  std::string listen = {};  // "host:port", port 0 takes a free one; empty: no metrics.
  // Whether an address that other machines reach may be served, in plain text and to whoever asks.
  bool insecure = false;
  int robots = kNamedRobots;  // Of a site that have series of their own.
};

// What a person has to put right before a start makes sense: InvalidArgument where the address is
// none of TCP, FailedPrecondition where others than this machine reach it and `insecure` does not
// say that they may.
absl::Status CheckListening(const MetricsOptions& options);

}  // namespace isthmus::metrics
