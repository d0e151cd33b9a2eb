#include "floam/recovery.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "floam/recovery_guesses.h"

namespace isthmus::floam {
namespace {

// Every guess is looked at once, with a part of the features and a wide loss, ...
constexpr int kGlanceStride = 8;
constexpr double kGlanceKernelM = 0.5;
// ... and the best are matched properly.
constexpr size_t kTries = 24;
constexpr int kTryStride = 3;

double Score(const MatchResult& match) { return match.agreement * match.used; }

}  // namespace

MatchResult Recover(const ScanFrame& frame, const MatchOptions& options, Tracker* tracker,
                    FeatureMap* map) {
  const auto match_from = [&](const ScanPose& guess, const MatchOptions& matching) {
    return tracker->matcher()->Match(frame.features, guess, std::nullopt, matching, map->surfaces(),
                                     map->edges());
  };
  MatchOptions glance = options;
  glance.stride = kGlanceStride;
  glance.max_iterations = 1;
  glance.kernel_start_m = kGlanceKernelM;
  std::vector<std::pair<double, ScanPose>> ranked;
  for (const ScanPose& guess : RecoveryGuesses(tracker->last(), tracker->ElapsedSeconds(frame),
                                               tracker->ReferenceTime(frame))) {
    ranked.emplace_back(Score(match_from(guess, glance)), guess);
  }
  const size_t tries = std::min(kTries, ranked.size());
  std::partial_sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(tries),
                    ranked.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  MatchOptions attempt = options;
  attempt.stride = kTryStride;
  attempt.kernel_start_m = kGlanceKernelM;
  MatchResult best;
  for (size_t k = 0; k < tries; ++k) {
    MatchResult match = match_from(ranked[k].second, attempt);
    if (k == 0 || Score(match) > Score(best)) best = std::move(match);
  }
  return tracker->Match(frame, best.pose, options, map);
}

}  // namespace isthmus::floam
