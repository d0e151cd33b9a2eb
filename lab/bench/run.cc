#include "lab/bench/run.h"

#include <algorithm>

#include "floam/odometry.h"
#include "floam/submap_builder.h"
#include "lab/bench/calibration.h"
#include "lab/bench/cpu_clock.h"
#include "lab/bench/memory.h"

namespace isthmus::bench {
namespace {

constexpr size_t kAtATime = 50;  // Scans in memory.

ScanOutcome OutcomeOf(floam::TrackingStatus status) {
  switch (status) {
    case floam::TrackingStatus::kOk:
      return ScanOutcome::kOk;
    case floam::TrackingStatus::kDegenerate:
      return ScanOutcome::kDegenerate;
    case floam::TrackingStatus::kLost:
      return ScanOutcome::kLost;
  }
  return ScanOutcome::kLost;
}

// Results may have segments, of which poses share a frame.
template <typename Result>
uint32_t SegmentOf(const Result& result) {
  if constexpr (requires { result.segment; }) return result.segment;
  return 0;
}

// As a session does: the odometry remembers the submaps that its poses make.
void Process(const Scan& scan, floam::Odometry* odometry, floam::SubmapBuilder* builder,
             ScanRecord* record) {
  const CpuClock processing;
  const auto result = odometry->Process(scan);
  record->ms = processing.Ms();
  if (!result.ok()) return;
  if (const auto submap = builder->Add(*result)) {
    const CpuClock remembering;
    odometry->Remember(*submap);
    record->ms += remembering.Ms();
  }
  record->outcome = OutcomeOf(result->status);
  record->T_odom_sensor = result->T_odom_sensor;
  record->segment = SegmentOf(*result);
  record->unobserved = result->degeneracy.translations;
  const floam::ScanTiming& timing = result->timing;
  const double parts_ms = timing.features_ms + timing.matching_ms + timing.map_ms;
  const double scale = parts_ms > 0 ? record->ms / parts_ms : 0;
  record->features_ms = scale * timing.features_ms;
  record->matching_ms = scale * timing.matching_ms;
  record->map_ms = scale * timing.map_ms;
}

}  // namespace

absl::StatusOr<RunRecord> Run(const Drive& drive, const floam::OdometryOptions& options) {
  const auto sensor = floam::FindSensorModel(drive.sensor);
  if (!sensor.ok()) return sensor.status();
  RunRecord run;
  run.scans.resize(drive.shots.size());
  ResetPeak();
  const double cal_before = CalibrationMs();
  const double heap_before = HeapMb();
  floam::Odometry odometry(*sensor, options);
  floam::SubmapBuilder builder(SessionId("robot-1"), RobotId("robot"), {});
  for (size_t begin = 0; begin < drive.shots.size(); begin += kAtATime) {
    const size_t end = std::min(begin + kAtATime, drive.shots.size());
    std::vector<Scan> scans;
    for (size_t i = begin; i < end; ++i) scans.push_back(MakeScan(drive, drive.shots[i], i + 1));
    for (size_t i = begin; i < end; ++i) {
      Process(scans[i - begin], &odometry, &builder, &run.scans[i]);
      run.scans[i].T_world_sensor = drive.truth_of(drive.shots[i].turn);
    }
    scans = {};
    run.scans[end - 1].heap_mb = HeapMb() - heap_before;
  }
  run.odometry_mb = HeapMb() - heap_before;
  run.cal_ms = std::min(cal_before, CalibrationMs());
  run.peak_mb = PeakMb();
  return run;
}

}  // namespace isthmus::bench
