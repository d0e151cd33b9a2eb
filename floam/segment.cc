#include "floam/segment.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include "floam/limits.h"
#include "floam/match/pose_covariance.h"

namespace isthmus::floam {
namespace {

double Seconds(int64_t from_ns, int64_t to_ns) {
  return 1e-9 * static_cast<double>(to_ns - from_ns);
}

}  // namespace

Segment::Segment(const SensorModel& sensor, const OdometryOptions& options)
    : options_(options),
      tracker_(sensor, options),
      map_(options),
      recovery_(options),
      relocaliser_(options.matching, RelocaliserOptions(), options.R_base_sensor) {}

absl::Status Segment::CheckFirst(const ScanFrame& frame) const {
  const size_t surfaces = frame.features.surfaces.size();
  if (static_cast<int>(surfaces) >= options_.min_used) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "scan ", frame.sequence, " shows only ", surfaces, " surface points, of ", options_.min_used,
      " needed to begin with; is the view blocked or the sensor model wrong?"));
}

std::optional<MatchResult> Segment::TrackSecondScan(const ScanFrame& frame) {
  // The little that a single scan shows fits in many places.
  if (tracker_.ElapsedSeconds(frame) > kLongestStartS) {
    start_.BeginAnew(frame, &tracker_);
    return std::nullopt;
  }
  MatchResult match = start_.TrackSecondScan(frame, &tracker_, &map_);
  if (!tracker_.Fits(match, map_)) {
    if (start_.attempts() >= kStartAttempts) start_.BeginAnew(frame, &tracker_);
    return std::nullopt;
  }
  quality_.Add(match);
  return match;
}

MatchResult Segment::MatchScan(const ScanFrame& frame, const ScanPose& prediction) {
  MatchResult match = tracker_.Match(frame, prediction, &map_);
  if (match.degeneracy.any() && !tracker_.IsDegenerate() && !map_.IsYoung()) {
    match = tracker_.Match(frame, tracker_.SteadyPrediction(frame, match.degeneracy), &map_);
  }
  if (lost_ || match.seconded || quality_.IsUsual(match)) return match;
  // New surroundings fit the map less well, and so does a wrong place: the scan before tells which.
  const MatchResult to_last = tracker_.MatchToLast(frame, prediction, &map_);
  return to_last.seconded ? to_last : match;
}

std::optional<MatchResult> Segment::TrackScan(const ScanFrame& frame, const ScanPose& prediction) {
  if (lost_ && !recovery_.IsDue()) return std::nullopt;
  MatchResult match = MatchScan(frame, prediction);
  if (!lost_ && tracker_.IsAfterGap(frame)) {
    const std::optional<MatchResult> around = recovery_.LookAround(frame, &tracker_, &map_);
    if (around && around->Score() > match.Score()) match = *around;
  }
  // A kidnapped robot's scan fits somewhere nearly as well as usual, now and then.
  const bool was_away = tracker_.IsAfterGap(frame) && !tracker_.WasAfterGap();
  const bool good = in_doubt_ > 0 || was_away ? quality_.IsTypical(match) : quality_.IsUsual(match);
  if (!lost_ && tracker_.Fits(match, map_) && (good || !was_away)) {
    const bool expected = tracker_.IsExpected(frame, match, prediction);
    const bool was_in_doubt = in_doubt_ > 0;
    in_doubt_ = expected && (match.seconded || good) ? 0 : in_doubt_ + 1;
    const bool contradicted =
        in_doubt_ == 0 && (was_in_doubt || was_away) && IsContradicted(frame, match);
    if (expected && !contradicted &&
        (in_doubt_ == 0 || (in_doubt_ <= kMostDoubtful && quality_.IsDoubtful(match)))) {
      quality_.Add(match);
      return match;
    }
    // If scan after scan leaves a direction unobserved, none shows that the motion along it was
    // different.
    if (!expected && match.degeneracy.any() && tracker_.IsSteady(frame) &&
        in_doubt_ <= kMostDoubtful) {
      match.pose = prediction;
      return match;
    }
  }
  in_doubt_ = 0;
  const Sighting lost_at = tracker_.last();
  std::optional<MatchResult> found = recovery_.Find(frame, match, quality_, &tracker_, &map_);
  if (found && IsContradicted(frame, *found)) {
    tracker_.BeginAt(lost_at);
    found.reset();
  }
  return found;
}

bool Segment::IsContradicted(const ScanFrame& frame, const MatchResult& match) {
  return quality_.IsContradicted(relocaliser_.Walls(frame, match.pose.At(0)));
}

void Segment::LookAtWalls(const ScanFrame& frame, const MatchResult& match) {
  if (in_doubt_ > 0 || tracked_s_ < next_look_s_) return;
  quality_.AddWalls(relocaliser_.Walls(frame, match.pose.At(0)));
  next_look_s_ = tracked_s_ + kWallLookS;
}

// The sensor was kidnapped: it goes on from there, in the map that was seen there before.
std::optional<MatchResult> Segment::Relocalise(const ScanFrame& frame) {
  std::optional<MatchResult> match = relocaliser_.Find(frame, tracker_.last().pose.T_odom_sensor,
                                                       quality_, tracker_.ReferenceTime(frame));
  if (match) {
    const Pose T_odom_end = match->pose.At(0);
    map_.Resume(relocaliser_.PointsAround(T_odom_end.translation(), options_.map.radius_m),
                T_odom_end);
  }
  return match;
}

// The initial pose for matching: the motion goes on or, in kAloam, is the one between the last two
// scans.
ScanPose Segment::Prediction(const ScanFrame& frame) {
  const ScanPose steady = tracker_.Prediction(frame);
  if (options_.mode != OdometryMode::kAloam || tracker_.IsAfterGap(frame)) return steady;
  return scan_to_scan_.Guess(frame.features, steady, tracker_.ElapsedSeconds(frame));
}

void Segment::AssessMatch(const MatchResult& match, bool relocalised, double elapsed_s,
                          OdometryResult* result) {
  const bool with_twist = options_.mode == OdometryMode::kContinuous;
  result->degeneracy =
      unobserved_.Lasting(DegeneracyAtEnd(match), match.pose.At(0).RotationMatrix(), elapsed_s);
  if (in_doubt_ > 0) result->degeneracy = Everything();  // It may be wrong altogether.
  if (result->degeneracy.any()) result->status = TrackingStatus::kDegenerate;
  if (in_doubt_ > 0) result->status = TrackingStatus::kLost;
  result->matched_covariance = MatchedCovarianceAtEnd(match, with_twist);
  result->covariance = Widened(result->matched_covariance, result->degeneracy);
  result->unobserved_covariance = relocalised ? unobserved_.StepAfterRelocalisation()
                                              : unobserved_.Step(result->degeneracy, elapsed_s);
}

ScanPose Segment::Extrapolate(const ScanPose& prediction, const ScanFrame& frame,
                              OdometryResult* result) {
  if (!lost_) searched_s_ = 0;
  if (lost_ && CheckFirst(frame).ok()) searched_s_ += Seconds(previous_ns_, frame.stamp_ns);
  lost_ = true;
  result->covariance = LostCovariance();
  result->unobserved_covariance = unobserved_.LostStep(Seconds(previous_ns_, frame.stamp_ns));
  result->status = TrackingStatus::kLost;
  previous_ns_ = frame.stamp_ns;
  return prediction;
}

ScanPose Segment::Locate(const ScanFrame& frame, OdometryResult* result) {
  if (phase_ == Phase::kFirst) {
    start_.TakeFirstScan(frame, &tracker_);
    phase_ = Phase::kSecond;
    previous_ns_ = frame.stamp_ns;
    return tracker_.last().pose;
  }
  const ScanPose prediction = Prediction(frame);
  std::optional<MatchResult> match;
  bool relocalised = false;
  if (phase_ == Phase::kSecond) {
    match = TrackSecondScan(frame);
  } else {
    match = TrackScan(frame, prediction);
    if (!match && !frame.features.work.spent()) {
      match = Relocalise(frame);
      relocalised = match.has_value();
    }
  }
  // As if it had not come: its time is not taken up, for it may be that of the next as well.
  if (frame.features.work.spent()) return prediction;
  if (!match) return Extrapolate(prediction, frame, result);
  if (lost_) {
    recovery_.Reset();
    relocaliser_.Reset();
  }
  if (relocalised) {
    tracker_.BeginAt({match->pose, frame.stamp_ns});  // Its motion, not the way it was carried.
  } else {
    tracker_.AdoptMatch(frame, map_, in_doubt_ > 0, &*match);
  }
  if (options_.mode == OdometryMode::kAloam) scan_to_scan_.SetPrevious(frame.features);
  phase_ = Phase::kUnderWay;
  const double elapsed_s = Seconds(previous_ns_, frame.stamp_ns);
  AssessMatch(*match, relocalised, elapsed_s, result);
  if (!lost_) {
    tracked_s_ += elapsed_s;
    LookAtWalls(frame, *match);
  }
  lost_ = false;
  previous_ns_ = frame.stamp_ns;
  return tracker_.last().pose;
}

void Segment::UpdateMap(const ScanFrame& frame) {
  if (lost_ || in_doubt_ > 0) return;
  map_.Update(frame.features, tracker_.last().pose, frame.period_s);
}

void Segment::Resume(const Cloud& map_odom, const Trajectory& recent) {
  const StampedPose& end = recent.back();
  ScanPose last;
  last.T_odom_sensor = end.pose;
  if (recent.size() > 1) {
    const StampedPose& before = recent[recent.size() - 2];
    const double elapsed_s = Seconds(before.stamp_ns, end.stamp_ns);
    if (elapsed_s > 0) last.twist = Log(before.pose.Inverse() * end.pose) / elapsed_s;
  }
  map_.Resume(map_odom, end.pose);
  tracker_.BeginAt({last, end.stamp_ns});
  previous_ns_ = end.stamp_ns;
  phase_ = Phase::kUnderWay;  // The motion is known, nothing has to be guessed.
}

}  // namespace isthmus::floam
