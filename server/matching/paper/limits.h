// Limits of the paper's chain that its options do not have: when RANSAC and the fit after it end.
#pragma once

namespace isthmus::matching {

// Logarithm of the chance to miss a consensus: once in a million draws. More draws cost time only.
inline constexpr double kMissedLog = -14;
// A sample of three inliers passes the edge tests once in so many cases. A guess, never counted;
// too small ends the search early.
inline constexpr double kEdgeLoss = 4;
// Times that inliers and fit are computed from each other. A guess, never varied; speed alone, once
// they settle.
inline constexpr int kFitRounds = 5;
// Share of the inliers that a fit has to keep, or it has left the consensus. A few it may lose: a
// sample of three is chosen for its count, yet all inliers together fix the transform better.
inline constexpr double kMinKeptShare = 0.8;

}  // namespace isthmus::matching
