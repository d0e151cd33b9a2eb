// The counts and times of a site's stages.
#pragma once

#include <prometheus/counter.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include <map>
#include <string>
#include <utility>

#include "core/concurrency/mutex.h"
#include "core/stage_observer.h"
#include "server/metrics/robot_names.h"

namespace isthmus::metrics {

// Times, seconds, from a scan that is quickly done to a pair of large maps. The same everywhere, so
// that histograms can be added up.
const prometheus::Histogram::BucketBoundaries& TimeBuckets();

// Thread safe. Events are counted without waiting for a scrape, but while one number is read.
class StageMetrics : public StageObserver {
 public:
  // The registry and the names must outlive it.
  StageMetrics(const std::string& site, RobotNames* robots, prometheus::Registry* registry);

  void NoteStage(Stage stage, double seconds) noexcept override;
  void NoteScan(const RobotId& robot, ScanOutcome outcome) noexcept override;

 private:
  const std::string site_;
  RobotNames& robots_;
  std::map<Stage, prometheus::Histogram*> stages_;
  prometheus::Family<prometheus::Counter>& scans_;
  Mutex mutex_;
  std::map<std::pair<std::string, ScanOutcome>, prometheus::Counter*> counters_
      ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::metrics
