#include "server/matching/pairs/decision.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>

#include "server/matching/pairs/limits.h"

namespace isthmus::matching {
namespace {

// The reason against accepting one hypothesis taken by itself; kOk for nothing.
struct Finding {
  MatchState state = MatchState::kAccepted;
  MatchReason reason = MatchReason::kOk;
  std::string detail;
};

// Rises from kEnclosedFromM2 to where nothing beyond is asked for.
double MaxEnclosedShare(double area_m2, const MatcherOptions& options) {
  if (area_m2 >= options.min_enclosed_area_m2) return 1;
  const double risen = std::max(0.0, area_m2 - kEnclosedFromM2) /
                       std::max(1.0, options.min_enclosed_area_m2 - kEnclosedFromM2);
  return options.max_enclosed_share + (1 - options.max_enclosed_share) * std::min(1.0, risen);
}

Finding Examine(const Hypothesis& h, const MatcherOptions& options) {
  const double violation = h.free_space.violation();
  if (!h.converged) {
    return {MatchState::kNotYet, MatchReason::kNotConverged,
            "The best alignment found did not settle."};
  }
  if (h.free_space.comparisons() < options.min_comparisons) {
    return {MatchState::kNotYet, MatchReason::kFewComparisons,
            absl::StrFormat("Only %d free-space comparisons where %d are needed.",
                            h.free_space.comparisons(), options.min_comparisons)};
  }
  if (h.overlap < options.min_overlap) {
    return {MatchState::kNotYet, MatchReason::kLowOverlap,
            absl::StrFormat("The best alignment overlaps by %.0f %% where %.0f %% are needed.",
                            100 * h.overlap, 100 * options.min_overlap)};
  }
  if (violation > h.max_free_space) {
    return {MatchState::kRejected, MatchReason::kFreeSpace,
            absl::StrFormat("One robot looked through what is a wall to the other in %.1f %% of "
                            "%d comparisons; at most %.1f %% are allowed.",
                            100 * violation, h.free_space.comparisons(), 100 * h.max_free_space)};
  }
  if (h.shared_area_m2 < options.min_shared_area_m2) {
    return {MatchState::kNotYet, MatchReason::kTooSmall,
            absl::StrFormat("The maps share only %.0f m2 of ground where %.0f m2 are needed: a "
                            "single room may have a twin.",
                            h.shared_area_m2, options.min_shared_area_m2)};
  }
  if (h.shared_share > MaxEnclosedShare(h.shared_area_m2, options)) {
    return {MatchState::kAmbiguous, MatchReason::kPossibleTwin,
            absl::StrFormat("The %.0f m2 that both maps show are %.0f %% of what is known: a place "
                            "built alike would fit as well. It is decided when a robot sees more, "
                            "or by hand.",
                            h.shared_area_m2, 100 * h.shared_share)};
  }
  if (h.observability < options.min_observability) {
    return {MatchState::kNotYet, MatchReason::kDegenerate,
            absl::StrFormat(
                "The alignment can slide in one direction (observability %.4f where %.4f is "
                "needed), as along a bare corridor.",
                h.observability, options.min_observability)};
  }
  if (h.odometry_residual > options.max_odometry_residual) {
    return {MatchState::kNotYet, MatchReason::kStrained,
            absl::StrFormat("The maps fit only if the odometry erred by %.1f of its standard "
                            "deviations where %.1f are allowed.",
                            h.odometry_residual, options.max_odometry_residual)};
  }
  return {};
}

// The competing hypothesis with the least contradictions, or null.
const Hypothesis* FindRival(const std::vector<Hypothesis>& ranked, const MatcherOptions& options) {
  const Hypothesis* rival = nullptr;
  for (size_t i = 1; i < ranked.size(); ++i) {
    const Hypothesis& h = ranked[i];
    if (h.free_space.comparisons() < options.min_comparisons) continue;
    if (h.overlap < 0.5 * options.min_overlap) continue;
    if (h.Support() < kMinRivalShare * ranked.front().Support()) continue;
    if (!rival || h.free_space.violation() < rival->free_space.violation()) rival = &h;
  }
  return rival;
}

// Another place where surfaces lie on each other more tightly, or null. What stands elsewhere on
// another day contradicts the right place, but what is fixed fits it as well as scans of one day.
const Hypothesis* FindTighter(const std::vector<Hypothesis>& ranked,
                              const MatcherOptions& options) {
  const Hypothesis& best = ranked.front();
  for (size_t i = 1; i < ranked.size(); ++i) {
    const Hypothesis& h = ranked[i];
    if (!h.converged || h.free_space.violation() > kMaxTighterViolation) continue;
    if (static_cast<double>(h.inliers) < kMinTighterShare * static_cast<double>(best.inliers)) {
      continue;
    }
    if (h.inlier_ratio < best.inlier_ratio - kTighterRatioSlack) continue;
    if (h.residual_m < options.max_tighter_residual * best.residual_m) return &h;
  }
  return nullptr;
}

// The probability that the alignment is right, after a logistic model of what was measured. Fitted
// to simulated pairs of museums and campuses, some of which had nothing in common; the curve is in
// docs/benchmarks/merging.md. Twins were left out: see `kTwinConfidence`.
double Confidence(const Hypothesis& h) {
  const double violation = h.free_space.violation() / (h.outdoors ? 0.08 : 0.02);
  const double comparisons = static_cast<double>(h.free_space.comparisons());
  const double logit =
      -1.77 + 2.25 * std::log10(1 + comparisons / 3000) - 1.91 * std::min(violation, 2.0) +
      2.30 * std::min(std::log1p(h.shared_area_m2 / 200), 1.8) - (h.converged ? 0 : 2.53);
  return 1 / (1 + std::exp(-logit));
}

void FillFigures(const Hypothesis& h, Match* match) {
  match->T_a_b = h.T_a_b;
  match->matcher = h.source;
  match->overlap = h.overlap;
  match->inliers = h.inliers;
  match->inlier_ratio = h.inlier_ratio;
  match->residual_m = h.residual_m;
  match->free_space = h.free_space.violation();
  match->comparisons = h.free_space.comparisons();
  match->runner_up = -1;
  match->shared_area_m2 = h.shared_area_m2;
  match->observability = h.observability;
  match->odometry_residual = h.odometry_residual;
  match->edges = h.joint.edges;
}

// The confidence in a hypothesis of which this is said.
double Confidence(const Hypothesis& h, MatchState state, MatchReason reason) {
  const bool may_be_twin = state == MatchState::kAmbiguous || reason == MatchReason::kTooSmall;
  return Confidence(h) * (may_be_twin ? kTwinConfidence : 1) *
         (state == MatchState::kRejected ? kContradictedConfidence : 1);
}

// What is said of one that is not the best. That the best is better makes it no worse than
// ambiguous: which of two is right may follow from other robots.
RivalMatch MakeRival(const Hypothesis& h, const MatcherOptions& options) {
  const Finding finding = Examine(h, options);
  RivalMatch rival;
  rival.T_a_b = h.T_a_b;
  const bool alone = finding.state == MatchState::kAccepted;
  rival.state = alone ? MatchState::kAmbiguous : finding.state;
  rival.reason = alone ? MatchReason::kAmbiguous : finding.reason;
  rival.confidence = Confidence(h, rival.state, rival.reason);
  rival.matcher = h.source;
  rival.overlap = h.overlap;
  rival.free_space = h.free_space.violation();
  rival.comparisons = h.free_space.comparisons();
  rival.shared_area_m2 = h.shared_area_m2;
  if (rival.state != MatchState::kRejected) rival.edges = h.joint.edges;
  return rival;
}

}  // namespace

void DecideState(const std::vector<Hypothesis>& ranked, const MatcherOptions& options,
                 Match* match) {
  if (ranked.empty()) {
    match->state = MatchState::kNotYet;
    match->reason = MatchReason::kNoCandidate;
    match->detail = "The search found no place where the maps could meet.";
    return;
  }
  const Hypothesis& best = ranked.front();
  FillFigures(best, match);
  match->rivals.clear();
  for (size_t i = 1; i < ranked.size(); ++i) {
    match->rivals.push_back(MakeRival(ranked[i], options));
  }
  Finding finding = Examine(best, options);
  const Hypothesis* rival = FindRival(ranked, options);
  if (rival) match->runner_up = rival->free_space.violation();
  const double floor = std::max(match->free_space, kFreeSpaceNoise);
  if (finding.state == MatchState::kAccepted && rival &&
      match->runner_up < options.min_margin * floor) {
    finding = {MatchState::kAmbiguous, MatchReason::kAmbiguous,
               absl::StrFormat("A second alignment is contradicted in %.2f %% of its comparisons, "
                               "the best in %.2f %%: too near to tell them apart.",
                               100 * match->runner_up, 100 * match->free_space)};
  }
  const Hypothesis* tighter = FindTighter(ranked, options);
  if (finding.state == MatchState::kAccepted && tighter) {
    finding = {MatchState::kAmbiguous, MatchReason::kAmbiguous,
               absl::StrFormat("At another place surfaces lie on each other more tightly, within "
                               "%.0f mm where it is %.0f mm at the best.",
                               1000 * tighter->residual_m, 1000 * best.residual_m)};
  }
  match->state = finding.state;
  match->reason = finding.reason;
  match->confidence = Confidence(best, finding.state, finding.reason);
  if (match->state == MatchState::kAccepted) {
    match->detail = absl::StrFormat(
        "Overlap %.0f %%, %.0f m2 shared, %.2f %% of %d free-space comparisons contradicted.",
        100 * match->overlap, best.shared_area_m2, 100 * match->free_space, match->comparisons);
    return;
  }
  match->detail = finding.detail;
}

}  // namespace isthmus::matching
