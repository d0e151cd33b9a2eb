// Limits of pose graphs: of the numbers in edges, and of the steps of graduated non-convexity.
//
// A number without a source is a guess that was never varied by itself. All of them together were
// in view on pose_graph_benchmark and mapping_benchmark (pose_graph.md and mapping.md in
// lab/docs).
#pragma once

namespace isthmus::pose_graph {

// Metres: a turn counts as what it moves at this distance, as far as most of what a submap shows.
// So limits in radians are those in metres over it. Larger makes every one of them stricter.
inline constexpr double kLeverM = 10;

// Standard deviation, as 1 / it: a kilometre and a thousand radians. Holds a freedom that nothing
// else holds, and bends nothing; a direction that an edge says nothing about is known no better.
inline constexpr double kSteadyingRoot = 1e-3;
inline constexpr double kLeastEdgeInformation = kSteadyingRoot * kSteadyingRoot;

// Graduated non-convexity; the truncation itself is Options::doubt_chi2.

// Edges that contradict sure ones by so many times doubt_chi2 are not tried at first. Less leaves
// out right ones whose drift was underrated, which costs steps, not the result.
inline constexpr double kGateMargin = 1.5;
// Steps of the trial with all weights at 1, and at each mu; the weights change after them anyway.
inline constexpr int kTrialIterations = 15, kInnerIterations = 8;
// Relative change of the cost at which a solution is good enough: the last, and one whose weights
// are not final. More than 1e-11 makes results depend on where the search began.
inline constexpr double kFineCostChange = 1e-11, kRoughCostChange = 1e-2;
// mu grows by this factor per step; Yang et al. take 1.4. More takes fewer steps and decides
// earlier.
inline constexpr double kMuGrowth = 2;
// mu begins no smaller: errors of 1e5 times the limit count at first, larger ones take only time.
inline constexpr double kLeastMu = 1e-5;
// Times that edges which the last solution left on the wrong side of the limit change it.
inline constexpr int kMaxReviews = 5;

// Edges are judged by the scale of their own errors (own_scale.h).

// Edges in doubt that it takes to tell a scale: of fewer no share says anything.
inline constexpr int kFewestToScale = 20;
// Each limit is so many times the one before, of variances, and so many are tried: sigmas up to 90
// times too small.
inline constexpr double kLimitGrowth = 2;
inline constexpr int kMostLimits = 14;
// More edges that the next limit may keep, of those kept: of honest right ones up to 2 % were
// beyond the first limit, of others 8 % and more (simulated teams of four robots).
inline constexpr double kFewFollow = 0.03;
// Share of the edges in doubt that must be kept: where nearly all are discarded, those that are
// left agree by chance.
inline constexpr double kLeastRight = 0.25;

}  // namespace isthmus::pose_graph
