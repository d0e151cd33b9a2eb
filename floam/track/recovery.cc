#include "floam/track/recovery.h"

#include <algorithm>
#include <utility>

#include "core/geometry/near.h"
#include "floam/match/limits.h"
#include "floam/relocalise/limits.h"
#include "floam/scan/undistort.h"
#include "floam/track/limits.h"
#include "floam/track/recovery_guesses.h"

namespace isthmus::floam {
namespace {

bool IsNearAny(const ScanPose& pose, const std::vector<ScanPose>& others) {
  return std::any_of(others.begin(), others.end(), [&](const ScanPose& other) {
    return AreNear(other.T_odom_sensor, pose.T_odom_sensor, kSamePlaceM, kDistinctRad);
  });
}

using Ranked = std::vector<std::pair<double, size_t>>;  // By score, of guesses.

// Evenly of the scan's surfaces, seen from the pose's time.
std::vector<Eigen::Vector3d> Sample(const Features& features, const ScanPose& pose, size_t count) {
  std::vector<Eigen::Vector3d> points;
  const size_t step = features.surfaces.size() / count + 1;
  const ScanMotion motion(pose.twist, pose.reference_s, -0.2, 0);
  for (size_t i = 0; i < features.surfaces.size(); i += step) {
    const TimedPoint& p = features.surfaces[i];
    points.push_back(motion.ToReference(p.position, p.time).cast<double>());
  }
  return points;
}

void Rank(const std::vector<ScanPose>& guesses, const std::vector<Eigen::Vector3d>& points,
          FeatureMap* map, Ranked* ranked) {
  for (auto& [score, k] : *ranked) {
    score = map->ScorePoints(points, guesses[k].T_odom_sensor, kGlanceKernelM);
  }
  std::sort(ranked->begin(), ranked->end(),
            [](const auto& a, const auto& b) { return a.first > b.first; });
}

std::vector<ScanPose> BestGuesses(const Features& features, const std::vector<ScanPose>& guesses,
                                  FeatureMap* map) {
  Ranked ranked;
  for (size_t k = 0; k < guesses.size(); ++k) ranked.emplace_back(0, k);
  // All guesses share the motion within the scan.
  const size_t better = kGuessesPerScan / 10;
  if (ranked.size() > better) {
    Rank(guesses, Sample(features, guesses.front(), kGlancePoints), map, &ranked);
    ranked.resize(better);
  }
  Rank(guesses, Sample(features, guesses.front(), 4 * kGlancePoints), map, &ranked);
  std::vector<ScanPose> best;
  for (const auto& [score, k] : ranked) {
    if (best.size() >= kFirstTries || score <= 0) break;
    if (!IsNearAny(guesses[k], best)) best.push_back(guesses[k]);
  }
  return best;
}

}  // namespace

Recovery::Recovery(const OdometryOptions& options) : matching_(options.matching) {}

void Recovery::Reset() {
  candidate_.reset();
  pending_.clear();
  lost_ = 0;
}

bool Recovery::IsDue() {
  const int lost = lost_++;
  return candidate_ || lost < kEagerSearches || lost % kSearchSpacing == 0;
}

std::optional<MatchResult> Recovery::Find(const ScanFrame& frame, const MatchResult& tracked,
                                          const MatchQuality& quality, Tracker* tracker,
                                          FeatureMap* map) {
  if (candidate_) {
    std::optional<MatchResult> match = ConfirmCandidate(frame, quality, tracker, map);
    if (match) return match;
  }
  const double elapsed_s = tracker->ElapsedSeconds(frame);
  std::optional<MatchResult> match;
  if (IsBelievable(tracked, quality, *tracker, elapsed_s, *map)) {
    match = tracked;
  } else {
    match = Search(frame, tracker, map);
    if (match && !IsBelievable(*match, quality, *tracker, elapsed_s, *map)) match.reset();
  }
  if (match) candidate_ = {match->pose, frame.stamp_ns};
  return std::nullopt;
}

// If a direction is not observed, a wrong place fits as well as the right one.
bool Recovery::IsBelievable(const MatchResult& match, const MatchQuality& quality,
                            const Tracker& tracker, double elapsed_s, const FeatureMap& map) const {
  if (match.degeneracy.any() || !tracker.Fits(match, map)) return false;
  const ScanPose& last = tracker.last().pose;
  const double away_m =
      (last.T_odom_sensor.Inverse() * match.pose.T_odom_sensor).translation().norm();
  const double driven_m = 2 * last.twist.head<3>().norm() * elapsed_s;
  const bool at_the_edge = elapsed_s < kEdgeS && away_m > kEdgeM && away_m < driven_m;
  return at_the_edge ? quality.IsTypicalAtTheEdge(match) : quality.IsTypical(match);
}

std::optional<MatchResult> Recovery::ConfirmCandidate(const ScanFrame& frame,
                                                      const MatchQuality& quality, Tracker* tracker,
                                                      FeatureMap* map) {
  const Sighting lost_at = tracker->last();
  const double elapsed_s = tracker->ElapsedSeconds(frame);
  tracker->BeginAt(*candidate_);
  candidate_.reset();
  const ScanPose prediction = tracker->Prediction(frame);
  MatchResult match = tracker->Match(frame, prediction, map);
  const bool as_foretold =
      tracker->IsAfterGap(frame)
          ? tracker->IsExpected(frame, match, prediction)
          : AreNear(prediction.T_odom_sensor, match.pose.T_odom_sensor, kForetoldM, kForetoldRad);
  const Sighting seen_at = tracker->last();
  tracker->BeginAt(lost_at);
  if (as_foretold && IsBelievable(match, quality, *tracker, elapsed_s, *map)) {
    tracker->BeginAt(seen_at);
    return match;
  }
  return std::nullopt;
}

std::vector<MatchResult> Recovery::MatchGuesses(const ScanFrame& frame,
                                                const std::vector<ScanPose>& guesses,
                                                int iterations, Tracker* tracker, FeatureMap* map) {
  MatchOptions attempt = matching_;
  attempt.stride = kRoughStride;
  attempt.max_iterations = iterations;
  attempt.kernel_start_m = kGlanceKernelM;
  std::vector<MatchResult> matches;
  for (const ScanPose& guess : guesses) {
    matches.push_back(tracker->matcher()->Match(frame.features, guess, Near(guess.T_odom_sensor),
                                                std::nullopt, attempt, map->surfaces(),
                                                map->edges(), map->poles()));
  }
  std::sort(matches.begin(), matches.end(),
            [](const auto& a, const auto& b) { return a.Score() > b.Score(); });
  return matches;
}

std::optional<MatchResult> Recovery::Search(const ScanFrame& frame, Tracker* tracker,
                                            FeatureMap* map) {
  std::vector<ScanPose> better;
  for (const MatchResult& match :
       MatchGuesses(frame, BestGuesses(frame.features, NextGuesses(frame, *tracker), map),
                    kTryIterations, tracker, map)) {
    if (better.size() < kBetterTries && !IsNearAny(match.pose, better)) {
      better.push_back(match.pose);
    }
  }
  const std::vector<MatchResult> matches =
      MatchGuesses(frame, better, 2 * kTryIterations, tracker, map);
  if (matches.empty()) return std::nullopt;
  const MatchResult& best = matches.front();
  for (const MatchResult& other : matches) {
    if (other.Score() > kAmbiguousScore * best.Score() &&
        !AreNear(other.pose.T_odom_sensor, best.pose.T_odom_sensor, kSamePlaceM, kGridRad)) {
      return std::nullopt;
    }
  }
  return tracker->MatchNear(frame, best.pose, matching_, map);
}

std::optional<MatchResult> Recovery::LookAround(const ScanFrame& frame, Tracker* tracker,
                                                FeatureMap* map) {
  pending_.clear();
  std::optional<MatchResult> match = Search(frame, tracker, map);
  pending_.clear();
  return match;
}

std::vector<ScanPose> Recovery::NextGuesses(const ScanFrame& frame, const Tracker& tracker) {
  const double elapsed_s = tracker.ElapsedSeconds(frame);
  const double reference_s = tracker.ReferenceTime(frame);
  std::vector<ScanPose> guesses = LikelyGuesses(tracker.last().pose, elapsed_s, reference_s);
  if (pending_.empty()) {
    pending_ = NearbyGuesses(tracker.last().pose, elapsed_s, reference_s);
    std::reverse(pending_.begin(), pending_.end());
  }
  while (guesses.size() < kGuessesPerScan && !pending_.empty()) {
    guesses.push_back(pending_.back());
    pending_.pop_back();
  }
  return guesses;
}

}  // namespace isthmus::floam
