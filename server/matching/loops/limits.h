// Limits of loop closures and revisits beside those of acceptance, which are LoopOptions: which
// older submaps are looked at, what odometry leaves open, and which submaps may be retired.
//
// Where no source is named a number is a guess that was never varied by itself. All of them
// together were in view on mapping_benchmark's loops, worlds 1 to 3 (lab/docs/mapping.md).
#pragma once

#include <cstddef>
#include <cstdint>

#include "server/matching/pairs/limits.h"

namespace isthmus::matching {

// Candidates: older submaps that the newest may lie on.

// Share of both radii that their middles may be apart, or they have too little in common; they may
// be nearer than it seems by this share of how far odometry may be off.
inline constexpr double kMaxLoopApart = 0.35, kReachShare = 0.5;
// Times of being apart that the way between has to be: a robot going straight on is no loop.
inline constexpr double kPathPerApart = 3;
// Metres within which they count as equally near, and older and newer ones take turns.
inline constexpr double kNearnessStepM = 3;
// Candidates that are looked at, and passes of which a search is made. Both bound the time.
inline constexpr size_t kMaxLoopCandidates = 48, kMaxSearches = 2;
// Metres, and over pose_graph::kLeverM radians: an edge that the placement contradicts by more was
// found wrong there, or is not in it yet.
inline constexpr double kPlacedM = 0.6;
// A loop that a person rejected is not offered again within so many metres and radians of it, and
// so many times LoopOptions::min_path_length_m along the way.
inline constexpr double kRejectedM = 2, kRejectedRad = 0.15, kRejectedWays = 2;
// A place that was searched in vain is left alone for this share of min_path_length_m: half a
// second each.
inline constexpr double kPatienceShare = 0.8;
// Prepared submaps that are kept at least: two windows, and as many candidates.
inline constexpr size_t kMinPreparedSubmaps = 16;

// Following: single submaps aligned where odometry knows their place well.

// Metres: what is known to kSubmapGateM is followed; known worse than the first, one alignment is
// believed only if another agrees within the second, and over pose_graph::kLeverM radians.
inline constexpr double kAloneM = 1.2, kAgreeM = 0.5;
// Metres, and over pose_graph::kLeverM radians: an alignment's own error, beside what is known.
inline constexpr double kAlignmentErrorM = 0.1;
// Single submaps need this part of LoopOptions::min_comparisons, which is for windows of several.
inline constexpr int64_t kComparisonShare = 2;
// Edges of one pass: the rest are left for other times of the way. A submap with fewer comes first,
// or it would lie where odometry has it once another is retired.
inline constexpr int kEdgesPerPass = 2;

// Submaps before the newest that it is aligned with: of one only, errors add up along the way; of
// more than three walls became no thinner (two museums and two campuses of 1 % drift, seeds 93,
// 94).
inline constexpr size_t kStepsBack = 3;

// Searching: windows of the newest submaps and of a place.

// Submaps of a window: the newest, and on either side of the place. Fewer show less to tell twins
// by.
inline constexpr size_t kNewestSubmaps = 3, kBesideSubmaps = 2;
// Share of min_path_length_m that lies between the windows at least.
inline constexpr double kWindowGapShare = 0.5;
// Metres, and over pose_graph::kLeverM radians, that an alignment captures indoors, where rooms are
// small; outdoors twice as far. Beyond, what looks alike and the bird's-eye search are asked.
inline constexpr double kCaptureM = 2.5;
// If odometry leaves so many times that distance open, all possible places have to be compared:
// another may be like the right one.
inline constexpr double kRivalReach = 2;
// Guesses from places that look alike.
inline constexpr size_t kWindowPlaceGuesses = 3;
// Radians that guesses (kGuessErrorM), metres and radians that verified alignments of windows are
// off by themselves.
inline constexpr double kGuessErrorRad = 0.1;
inline constexpr double kWindowErrorM = 0.15, kWindowErrorRad = 0.01;
// Hypotheses refined jointly, and times the limit of free space that a rigid one may be
// contradicted, as drift contradicts right ones before it is taken out (decision 0010). Less loses
// loops with drift, more takes time.
inline constexpr size_t kMaxJointLoops = 3;
inline constexpr double kLoopLeniency = 10;

// Odometry and loops.

// Information added to an edge's, per square metre and radian: where it says nothing it is good to
// a hundred metres, and can still be inverted.
inline constexpr double kLeastLoopInformation = 1e-4;

// Revisits: submaps whose places were seen again since; RevisitOptions says how often.

// Points of a submap that are asked, and of how many of the older ones, the nearest, and of the new
// ones of a call. Time and memory are bounded by them.
inline constexpr size_t kRevisitPoints = 300, kMaxOlder = 96, kMaxNewPerCall = 6;
// Share of both radii that middles may be apart to look at each other, and to be one place.
inline constexpr double kMaxRevisitApart = 0.8, kSamePlaceShare = 0.3;
// Points that were looked at, below which a contradiction says nothing.
inline constexpr int kMinSeenPoints = 10;
// Submaps, or a share of the session, for which a map is made anew; and those of one place that go
// at once, so that what holds the rest does not go with them.
inline constexpr size_t kMinBatch = 4, kMaxOfAPlace = 4;
inline constexpr double kMinBatchShare = 0.05;

// Share contradicted below which a right and a wrong hypothesis are noise: LoopOptions::min_margin
// is taken of no less.
inline constexpr double kFreeSpaceNoise = 0.002;

}  // namespace isthmus::matching
