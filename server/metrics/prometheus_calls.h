// The counts and times of calls, by method and by how they ended.
#pragma once

#include <absl/status/status.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include <map>
#include <string>
#include <utility>

#include "core/concurrency/mutex.h"

namespace isthmus::metrics {

// Thread safe.
class CallMetrics {
 public:
  // The registry must outlive it.
  explicit CallMetrics(prometheus::Registry* registry);

  // The method is one of ours: what others write is no label.
  void NoteCall(const std::string& method, absl::StatusCode code, double seconds) noexcept;

 private:
  prometheus::Family<prometheus::Histogram>& durations_;
  Mutex mutex_;
  std::map<std::pair<std::string, absl::StatusCode>, prometheus::Histogram*> histograms_
      ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::metrics
