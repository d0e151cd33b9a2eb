#include "floam/odometry.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <cstdint>
#include <optional>
#include <utility>

#include "core/stopwatch.h"
#include "floam/feature_map.h"
#include "floam/match_quality.h"
#include "floam/odometry_options.h"
#include "floam/options_checksum.h"
#include "floam/pose_covariance.h"
#include "floam/recovery.h"
#include "floam/relocaliser.h"
#include "floam/scan_frame.h"
#include "floam/scan_to_scan.h"
#include "floam/start.h"
#include "floam/state_codec.h"
#include "floam/tracker.h"
#include "floam/undistort.h"
#include "floam/unobserved_motion.h"

namespace isthmus::floam {
namespace {

// Scans after the first that may fail to match it, before it begins anew.
constexpr int kStartAttempts = 3;

constexpr char kStateMagic[] = "IODO";
// Becomes another with every change of what is stored, or of what is made of it.
constexpr uint32_t kStateVersion = 1;

}  // namespace

struct Odometry::State {
  State(const SensorModel& sensor_model, const OdometryOptions& odometry_options)
      : sensor(sensor_model),
        options(odometry_options),
        maker(sensor, odometry_options.features),
        tracker(sensor, odometry_options),
        map(odometry_options),
        recovery(odometry_options),
        relocaliser(odometry_options.matching, RelocaliserOptions(),
                    odometry_options.R_base_sensor) {}

  enum class Phase : uint8_t { kFirst, kSecond, kUnderWay };

  const SensorModel sensor;
  const OdometryOptions options;
  FrameMaker maker;
  Tracker tracker;
  FeatureMap map;
  ScanToScan scan_to_scan;  // kAloam.
  Start start;
  MatchQuality quality;
  UnobservedMotion unobserved;
  Recovery recovery;
  Relocaliser relocaliser;
  bool lost = false;  // The scan before was.

  Phase phase = Phase::kFirst;
  int64_t previous_ns = 0;  // Stamp of the last scan taken, matched or not.
  ScanFrame frame;          // The one being processed.

  double SincePrevious() const { return 1e-9 * static_cast<double>(frame.stamp_ns - previous_ns); }
  absl::Status Prepare(const Scan& input);
  // For state_codec.h. The frame is made anew for every scan, and `start` is not asked any more
  // once under way.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.phase, self.previous_ns, self.lost, self.maker, self.tracker, self.map,
       self.scan_to_scan, self.quality, self.unobserved, self.recovery, self.relocaliser);
    if constexpr (Io::kIsReading) io.Expect(self.phase <= Phase::kUnderWay);
    if (self.phase == Phase::kSecond) io(self.start);
  }

  ScanPose Locate(OdometryResult* result);
  void Assess(const MatchResult& match, bool carried, OdometryResult* result);
  ScanPose Prediction();
  std::optional<MatchResult> Second();
  std::optional<MatchResult> Follow(const ScanPose& prediction);
  std::optional<MatchResult> Relocalise();
};

absl::Status Odometry::State::Prepare(const Scan& input) {
  const int64_t* previous = phase == Phase::kFirst ? nullptr : &previous_ns;
  if (absl::Status status = maker.Make(input, previous, &frame); !status.ok()) return status;
  const size_t surfaces = frame.features.surfaces.size();
  if (phase == Phase::kFirst && static_cast<int>(surfaces) < options.min_used) {
    return absl::InvalidArgumentError(absl::StrCat(
        "scan ", input.sequence, " shows only ", surfaces, " surface points, of ", options.min_used,
        " needed to begin with; is the view blocked or the sensor model wrong?"));
  }
  return absl::OkStatus();
}

// Each of these returns a match to be believed, or none.
std::optional<MatchResult> Odometry::State::Second() {
  // Two scans far apart in time have no motion in common, and what little a single scan shows fits
  // in many places.
  if (tracker.IsAfterGap(frame)) {
    start.Again(frame, &tracker);
    return std::nullopt;
  }
  MatchResult match = start.Second(frame, &tracker, &map);
  if (!tracker.Fits(match, map)) {
    if (start.attempts() >= kStartAttempts) start.Again(frame, &tracker);
    return std::nullopt;
  }
  quality.Add(match);
  return match;
}

std::optional<MatchResult> Odometry::State::Follow(const ScanPose& prediction) {
  MatchResult match = tracker.Match(frame, prediction, tracker.Matching(map), &map);
  if (match.degeneracy.any() && !tracker.IsDegenerate() && !map.IsYoung()) {
    const ScanPose steady = tracker.SteadyPrediction(frame, match.degeneracy);
    match = tracker.Match(frame, steady, tracker.Matching(map), &map);
  }
  if (!lost && !tracker.IsAfterGap(frame) && tracker.Fits(match, map) &&
      tracker.IsExpected(match, prediction) && quality.IsUsual(match)) {
    quality.Add(match);
    return match;
  }
  return recovery.Find(frame, match, quality, &tracker, &map);
}

// The sensor was carried away: it goes on from there, in the map that was seen there before.
std::optional<MatchResult> Odometry::State::Relocalise() {
  std::optional<MatchResult> match = relocaliser.Find(frame, tracker.last().pose.T_odom_sensor,
                                                      quality, tracker.ReferenceTime(frame));
  if (match) {
    const Pose T_odom_end = match->pose.At(0);
    map.Resume(relocaliser.PointsAround(T_odom_end.translation(), options.map.radius_m),
               T_odom_end);
  }
  return match;
}

// Where matching begins: the motion goes on or, in kAloam, is what the last two scans tell.
ScanPose Odometry::State::Prediction() {
  const ScanPose steady = tracker.Prediction(frame);
  if (options.mode != OdometryMode::kAloam || tracker.IsAfterGap(frame)) return steady;
  return scan_to_scan.Guess(frame.features, steady, tracker.ElapsedSeconds(frame));
}

// Sets the result's status, covariances and degeneracy.
void Odometry::State::Assess(const MatchResult& match, bool carried, OdometryResult* result) {
  const bool with_twist = options.mode == OdometryMode::kContinuous;
  result->covariance = CovarianceAtEnd(match, with_twist);
  result->degeneracy = DegeneracyAtEnd(match);
  if (match.degeneracy.any()) result->status = TrackingStatus::kDegenerate;
  result->matched_covariance = MatchedCovarianceAtEnd(match, with_twist);
  result->unobserved_covariance =
      carried ? unobserved.CarriedStep() : unobserved.Step(result->degeneracy, SincePrevious());
}

// Where the scan was; sets what Assess does.
ScanPose Odometry::State::Locate(OdometryResult* result) {
  if (phase == Phase::kFirst) {
    start.First(frame, &tracker);
    phase = Phase::kSecond;
    return tracker.last().pose;
  }
  const ScanPose prediction = Prediction();
  std::optional<MatchResult> match;
  bool carried = false;
  if (phase == Phase::kSecond) {
    match = Second();
  } else {
    match = Follow(prediction);
    if (!match) {
      match = Relocalise();
      carried = match.has_value();
    }
  }
  if (lost && match) {
    recovery.Reset();
    relocaliser.Reset();
  }
  lost = !match;
  if (!match) {
    result->covariance = LostCovariance();
    result->unobserved_covariance = unobserved.LostStep(SincePrevious());
    result->status = TrackingStatus::kLost;
    return prediction;
  }
  if (carried) {
    tracker.Begin({match->pose, frame.stamp_ns});  // Its motion, not the way it was carried.
  } else {
    tracker.Adopt(frame, map, &*match);
  }
  if (options.mode == OdometryMode::kAloam) scan_to_scan.SetPrevious(frame.features);
  phase = Phase::kUnderWay;
  Assess(*match, carried, result);
  return tracker.last().pose;
}

Odometry::Odometry(const SensorModel& sensor, const OdometryOptions& options)
    : state_(std::make_unique<State>(sensor, options)) {}

Odometry::~Odometry() = default;

void Odometry::Resume(const Cloud& map_odom, const Trajectory& recent) {
  State& state = *state_;
  const StampedPose& end = recent.back();
  ScanPose last;
  last.T_odom_sensor = end.pose;
  if (recent.size() > 1) {
    const StampedPose& before = recent[recent.size() - 2];
    const double elapsed_s = 1e-9 * static_cast<double>(end.stamp_ns - before.stamp_ns);
    if (elapsed_s > 0) last.twist = Log(before.pose.Inverse() * end.pose) / elapsed_s;
  }
  state.map.Resume(map_odom, end.pose);
  state.tracker.Begin({last, end.stamp_ns});
  state.previous_ns = end.stamp_ns;
  state.phase = State::Phase::kUnderWay;  // The motion is known, nothing has to be guessed.
}

void Odometry::Remember(const Submap& submap) { state_->relocaliser.Remember(submap); }

std::string Odometry::Save() const {
  StateWriter writer;
  const State& state = *state_;
  writer(state);
  return SealState(kStateMagic, kStateVersion, OptionsChecksum(state.sensor, state.options),
                   writer.Take());
}

absl::Status Odometry::Restore(const std::string& saved) {
  absl::StatusOr<StateReader> reader =
      OpenState(kStateMagic, kStateVersion, OptionsChecksum(state_->sensor, state_->options), saved,
                "the odometry");
  if (!reader.ok()) return reader.status();
  auto restored = std::make_unique<State>(state_->sensor, state_->options);
  (*reader)(*restored);
  if (!reader->ok() || reader->remaining() > 0) {
    return absl::DataLossError("the state of the odometry is damaged: it contradicts itself");
  }
  restored->relocaliser.TakeMemory(&state_->relocaliser);
  state_ = std::move(restored);
  return absl::OkStatus();
}

absl::StatusOr<OdometryResult> Odometry::Process(const Scan& scan) {
  State& state = *state_;
  const Stopwatch total;
  Stopwatch stage;
  if (absl::Status status = state.Prepare(scan); !status.ok()) return status;
  OdometryResult result;
  result.sequence = scan.sequence;
  result.stamp_ns = scan.end_stamp_ns;
  result.rings_from = state.frame.scan.rings_from;
  result.times_from = state.frame.scan.times_from;
  result.input = state.frame.scan.text;
  result.timing.features_ms = stage.Lap();

  const ScanPose pose = state.Locate(&result);
  state.previous_ns = scan.end_stamp_ns;
  result.T_odom_sensor = pose.At(0);
  result.timing.matching_ms = stage.Lap();
  if (result.status != TrackingStatus::kLost) {
    state.map.Update(state.frame.features, pose, state.frame.period_s);
  }
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
