// Limits of the place index: what is kept of a session's map, and how plans are compared.
//
// The formula of the score and what it is divided by were chosen on merging_benchmark's wild worlds
// of seeds 1100 to 1121 (lab/docs/merging.md has fresh ones). Where nothing else is said a
// number is a guess that was never varied by itself. None of them changes a map: they change which
// pairs of sessions are searched first.
#pragma once

#include <cstddef>

namespace isthmus::matching {

// Plans.

// Metres: cell of a plan. At 0.5 m 0.54 of the overlapping pairs of one kind came before 94 %
// of the strangers, at 0.25 m 0.66 (seeds above). Doubled while a plan is more than so many cells
// from corner to corner: a comparison takes 60 MB then.
inline constexpr float kPlanCellM = 0.25f;
inline constexpr float kMaxPlanSide = 1500;
// Metres from where the sensor was: farther, measurements are sparse, and memory grows.
inline constexpr float kPlanReachM = 40;
// Points from which the vertical is estimated; radians that it may lie from odom's z: sensors are
// mounted askew by up to 25 degrees, and what looks like more is a ceiling taken for the floor.
inline constexpr size_t kPlanLevelPoints = 20'000;
inline constexpr double kMaxPlanTiltRad = 0.7;
// Metres above the ground where upright surfaces count, and height of one of their layers; the
// lowest kLowLayers reach up to where a robot looks across: there something may stand in the way.
inline constexpr float kPlanLowM = 0.5f, kLayerM = 0.5f;
inline constexpr int kPlanLayers = 16, kLowLayers = 4;
// Layers filled from which on a cell counts in full, of the low ones and of those above, and from
// which on it cannot be looked across.
inline constexpr float kFullLow = 2, kFullHigh = 3;
inline constexpr int kBlockingLayers = 3;
// Rays across a cell that make it free.
inline constexpr int kFreeHits = 2;

// Comparison.

// Metres: maps with a radius up to the first are correlated at twice kPlanCellM, up to the second
// at four times, and so on. Finer finds more and takes four times as long.
inline constexpr float kFineRadiusM = 25, kMiddleRadiusM = 80;
// Yaws that are tried, 4 degrees apart: coarser, distant walls do not fit.
inline constexpr int kPlanYaws = 90;
// Bytes of the images of a plan at all yaws, transformed, that are kept while it is compared with
// others; what would take more is made again each time. A guess.
inline constexpr size_t kMaxTurnedBytes = size_t{96} << 20;
// Placements that are looked at closely, of so many peaks. Of 6 the right one was among them in
// 0.64 of the pairs, of 16 in 0.69.
inline constexpr size_t kPlanPeaks = 80, kPlanPolished = 12;
// Cells of either plan that are asked while a placement is polished. Speed, and noise.
inline constexpr size_t kPolishCells = 500;
// Share of the agreement that does not depend on which way a wall faces, as kUnorientedShare.
inline constexpr float kPlanUnoriented = 0.3f;
// The score of two plans is their agreement over this power of the smaller one's walls: at 1 small
// maps would come first, at 0 large ones.
inline constexpr double kPlanSizePower = 0.75;

// Ranking.

// Sessions up to which all pairs are searched: 66.
inline constexpr size_t kSearchAllSessions = 12;
// Partners that each session is searched with once there are more, at most and mostly: a search
// counts for both, and is made while either has room. Of 100 sessions' pairs that is 10 % at most.
inline constexpr size_t kSearchPartners = 5;
// Partners that are looked at until kSearchPartners were worth a search in full
// (MatcherOptions::first_look).
inline constexpr size_t kLookedPartners = 20;
// Partners of its own component, those among the likeliest included. Beyond these it is tried with
// such as lie beside it: nearly all of these find something, and each makes the map stiffer. A
// guess.
inline constexpr size_t kNearPartners = 10;
// Shares of a session's scores. A score counts by how far it lies above the middle one, in units of
// the distance between the lower and the upper of these shares.
inline constexpr double kLowShare = 0.2, kHighShare = 0.8;
// Share of the sum of a pair's two standings that is added to the lesser one. At 0 the partners of
// a session with one score are all alike, with the sum alone a map that fits everywhere comes
// first.
inline constexpr double kSumShare = 0.25;
// Bytes of plans that are kept; others are made again from the prepared submaps when asked for.
inline constexpr size_t kMaxPlanBytes = size_t{64} << 20;

}  // namespace isthmus::matching
