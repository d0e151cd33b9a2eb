#include "server/metrics/prometheus_calls.h"

#include "server/metrics/prometheus_stages.h"

namespace isthmus::metrics {

CallMetrics::CallMetrics(prometheus::Registry* registry)
    : durations_(prometheus::BuildHistogram()
                     .Name("isthmus_rpc_duration_seconds")
                     .Help("Time from the beginning of each call to its end.")
                     .Register(*registry)) {}

void CallMetrics::NoteCall(const std::string& method, absl::StatusCode code,
                           double seconds) noexcept {
  try {
    MutexLock lock(&mutex_);
    prometheus::Histogram*& histogram = histograms_[{method, code}];
    if (histogram == nullptr) {
      histogram = &durations_.Add({{"method", method}, {"code", absl::StatusCodeToString(code)}},
                                  TimeBuckets());
    }
    histogram->Observe(seconds);
  } catch (...) {
    // One call less in the statistics.
  }
}

}  // namespace isthmus::metrics
