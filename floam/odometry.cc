#include "floam/odometry.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "core/state_codec.h"
#include "core/stopwatch.h"
#include "floam/limits.h"
#include "floam/odometry_options.h"
#include "floam/scan/scan_frame.h"
#include "floam/scan/undistort.h"
#include "floam/segment.h"
#include "floam/state/options_checksum.h"

namespace isthmus::floam {
namespace {

constexpr char kOdometryMagic[] = "IODO";
// Becomes another with every change of what is stored, or of what is made of it.
constexpr uint32_t kOdometryVersion = 8;  // Format.

const char* NameOf(Work::Kind spent_on) {
  switch (spent_on) {
    case Work::Kind::kNeighbours:
      return "too many points lie in the same directions";
    case Work::Kind::kRings:
      return "times or places of points jump about within rings";
    case Work::Kind::kScanToScan:
      return "too much is near each of its points in the scan before: too many rings, or points "
             "around the sensor's axis";
    case Work::Kind::kMap:
      return "too many edges or surfaces are to be matched";
    case Work::Kind::kNone:
      break;
  }
  return "";
}

absl::Status TooMuchWork(const ScanFrame& frame, uint64_t most) {
  return absl::InvalidArgumentError(absl::StrCat(
      "scan ", frame.sequence, " takes more than ", most,
      " steps of work, far more than others of its size: ", NameOf(frame.features.work.spent_on()),
      "; send fewer points, or thin them"));
}

}  // namespace

struct Odometry::State {
  State(const SensorModel& sensor_model, const OdometryOptions& odometry_options)
      : sensor(sensor_model),
        options(odometry_options),
        maker(sensor, odometry_options.features),
        segment(std::make_unique<Segment>(sensor, options)) {}

  const SensorModel sensor;
  const OdometryOptions options;
  FrameMaker maker;
  std::unique_ptr<Segment> segment;
  uint32_t segment_number = 1;
  double patience_s = kLeastPatienceS;  // With a segment that was not worth beginning.
  ScanFrame frame;                      // The one being processed.

  absl::Status Prepare(const Scan& input);
  ScanPose Locate(OdometryResult* result);
  bool IsWorthwhile() const { return segment->TrackedSeconds() >= kWorthwhileS; }
  double PatienceS() const;
  void BeginSegment();

  // For state_codec.h. The frame is made anew for every scan.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.segment_number, self.patience_s, self.maker, *self.segment);
  }
};

absl::Status Odometry::State::Prepare(const Scan& input) {
  const int64_t previous_ns = segment->previous_ns();
  const bool is_first = !segment->HasBegun();
  absl::Status status = maker.Make(input, is_first ? nullptr : &previous_ns, &frame);
  if (status.ok() && frame.features.work.spent()) {
    status = TooMuchWork(frame, options.features.max_work);
  }
  if (!status.ok() || !is_first) return status;
  return segment->CheckFirst(frame);
}

double Odometry::State::PatienceS() const {
  if (IsWorthwhile()) return kPatienceS;
  return std::max(patience_s, std::min(kPatienceS, 0.5 * segment->TrackedSeconds()));
}

// Earlier observations must not be mixed with later ones: nothing is known of the motion in
// between.
void Odometry::State::BeginSegment() {
  patience_s = IsWorthwhile() ? kLeastPatienceS : std::min(2 * patience_s, kLongestPatienceS);
  segment = std::make_unique<Segment>(sensor, options);
  ++segment_number;
}

// The result's status and the rest that rests on the match are set; the input's words are not.
ScanPose Odometry::State::Locate(OdometryResult* result) {
  ScanPose pose = segment->Locate(frame, result);
  if (frame.features.work.spent()) return pose;
  if (segment->SearchedSeconds() >= PatienceS() && segment->CheckFirst(frame).ok()) {
    BeginSegment();
    *result = OdometryResult();
    pose = segment->Locate(frame, result);
  }
  result->segment = segment_number;
  return pose;
}

Odometry::Odometry(const SensorModel& sensor, const OdometryOptions& options)
    : state_(std::make_unique<State>(sensor, options)) {}

Odometry::~Odometry() = default;

void Odometry::Resume(const Cloud& map_odom, const Trajectory& recent, uint32_t segment) {
  state_->segment->Resume(map_odom, recent);
  state_->segment_number = segment;
}

void Odometry::Remember(const Submap& submap) { state_->segment->Remember(submap); }

const ScanFrame& Odometry::frame() const { return state_->frame; }
const MatchQuality& Odometry::quality() const { return state_->segment->quality(); }

std::string Odometry::Save() const {
  StateWriter writer;
  const State& state = *state_;
  writer(state);
  return SealState(kOdometryMagic, kOdometryVersion, OptionsChecksum(state.sensor, state.options),
                   writer.Take());
}

absl::Status Odometry::Restore(const std::string& saved) {
  absl::StatusOr<StateReader> reader =
      OpenState(kOdometryMagic, kOdometryVersion, OptionsChecksum(state_->sensor, state_->options),
                saved, "the odometry");
  if (!reader.ok()) return reader.status();
  auto restored = std::make_unique<State>(state_->sensor, state_->options);
  (*reader)(*restored);
  if (!reader->ok() || reader->remaining() > 0) {
    return absl::DataLossError("the state of the odometry is damaged: it contradicts itself");
  }
  restored->segment->TakeMemory(state_->segment.get());
  state_ = std::move(restored);
  return absl::OkStatus();
}

absl::StatusOr<OdometryResult> Odometry::Process(const Scan& scan) {
  State& state = *state_;
  const Stopwatch total;
  Stopwatch stage;
  if (absl::Status status = state.Prepare(scan); !status.ok()) return status;
  const double features_ms = stage.Lap();

  OdometryResult result;
  const ScanPose pose = state.Locate(&result);
  if (state.frame.features.work.spent()) {
    return TooMuchWork(state.frame, state.options.features.max_work);
  }
  result.sequence = scan.sequence;
  result.stamp_ns = scan.end_stamp_ns;
  result.rings_from = state.frame.scan.rings_from;
  result.times_from = state.frame.scan.times_from;
  result.input = state.frame.scan.text;
  result.T_odom_sensor = pose.At(0);
  result.timing.features_ms = features_ms;
  result.timing.matching_ms = stage.Lap();
  state.segment->UpdateMap(state.frame);
  result.timing.map_ms = stage.Lap();
  if (state.options.undistort_cloud) {
    const ScanMotion motion(pose.twist, 0, -state.frame.period_s, 0);
    Undistort(state.frame.scan, motion, &result.undistorted);
  }
  result.timing.matching_ms += stage.Lap();
  result.timing.total_ms = total.Ms();
  return result;
}

}  // namespace isthmus::floam
