#include "server/metrics/prometheus_stages.h"

namespace isthmus::metrics {
namespace {

const char* NameOf(Stage stage) {
  switch (stage) {
    case Stage::kDecode:
      return "decode";
    case Stage::kOdometry:
      return "odometry";
    case Stage::kAcknowledge:
      return "acknowledge";
    case Stage::kDurable:
      return "durable";
    case Stage::kStore:
      return "store";
    case Stage::kMatch:
      return "match";
    case Stage::kLoopSearch:
      return "loop_search";
    case Stage::kPlacement:
      return "placement";
    case Stage::kComposition:
      return "composition";
  }
  return "unknown";
}

const char* NameOf(ScanOutcome outcome) {
  switch (outcome) {
    case ScanOutcome::kProcessed:
      return "processed";
    case ScanOutcome::kDuplicate:
      return "duplicate";
    case ScanOutcome::kRejected:
      return "rejected";
    case ScanOutcome::kSkipped:
      return "skipped";
  }
  return "unknown";
}

}  // namespace

const prometheus::Histogram::BucketBoundaries& TimeBuckets() {
  static const auto* const buckets = new prometheus::Histogram::BucketBoundaries{
      0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 30, 60, 120, 300};
  return *buckets;
}

StageMetrics::StageMetrics(const std::string& site, RobotNames* robots,
                           prometheus::Registry* registry)
    : site_(site),
      robots_(*robots),
      scans_(prometheus::BuildCounter()
                 .Name("isthmus_scans_total")
                 .Help("Scans that were acknowledged, by what became of them.")
                 .Register(*registry)) {
  auto& family = prometheus::BuildHistogram()
                     .Name("isthmus_stage_duration_seconds")
                     .Help("Wall time that each stage took.")
                     .Register(*registry);
  for (const Stage stage : kAllStages) {
    stages_[stage] = &family.Add({{"site", site}, {"stage", NameOf(stage)}}, TimeBuckets());
  }
}

void StageMetrics::NoteStage(Stage stage, double seconds) noexcept {
  try {
    stages_.at(stage)->Observe(seconds);
  } catch (...) {
    // One time less in the statistics.
  }
}

void StageMetrics::NoteScan(const RobotId& robot, ScanOutcome outcome) noexcept {
  try {
    std::string name = robots_.NameOf(robot);
    MutexLock lock(&mutex_);
    prometheus::Counter*& counter = counters_[{name, outcome}];
    if (counter == nullptr) {
      counter = &scans_.Add({{"site", site_}, {"robot", name}, {"outcome", NameOf(outcome)}});
    }
    counter->Increment();
  } catch (...) {
    // One scan less in the statistics.
  }
}

}  // namespace isthmus::metrics
