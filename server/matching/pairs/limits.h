// Limits of matching pairs beside those of acceptance, which are MatcherOptions: which hypotheses
// are worth what, and when they count as one.
//
// Where no source is named a number is a guess that was never varied by itself. All of them
// together were in view on merging_benchmark's seeds 11 to 20 and held on 21 to 30 (BENCHMARK.md,
// Merging).
#pragma once

#include <cstddef>
#include <cstdint>

namespace isthmus::matching {

// Which hypotheses are worth a closer look.

// Radians, 11 degrees: maps are levelled, and what stands more askew to gravity is no merge of
// them. A building turned upside down fits its mirror image.
inline constexpr double kMaxTiltRad = 0.2;
// Share of the best one's score or support below which a hypothesis is no rival: a twin scores half
// of it and more. Larger could leave a twin out, and then the pair would be believed.
inline constexpr double kMinRivalShare = 0.1;
// Guesses from places that look alike, of whole maps and of new submaps.
inline constexpr size_t kPlaceGuesses = 4, kNewPlaceGuesses = 2;
// Hypotheses that are refined jointly, the dearest step. Fewer may leave out a rival.
inline constexpr size_t kMaxJoint = 4;
// And those beyond in which surfaces agree best, for places of which free space says little. A
// guess: each takes a quarter of a second.
inline constexpr size_t kMaxJointByAgreement = 2;
// Times the limit of free space that a rigid alignment may be contradicted: drift contradicts right
// ones before it is taken out (decision 0010). Less loses pairs with drift, more takes time.
inline constexpr double kRigidLeniency = 20;
// What a guess of new submaps must show before the whole is searched for it: share contradicted,
// and comparisons. Stricter, a meeting is found only when the maps have grown by a quarter.
inline constexpr double kMaxGuessViolation = 0.08;
inline constexpr int64_t kMinGuessComparisons = 500;
// Growth after which an accepted pair is searched elsewhere too; open ones are by kNewMapGrowth.
inline constexpr double kAcceptedGrowth = 2.0;

// Joint refinement.

// Submaps of the other map that each is aligned with, and how far apart their middles may be, as a
// share of their radii. Fewer edges hold less against drift; farther ones have little in common.
inline constexpr size_t kPartners = 4;
inline constexpr double kMaxPartnersApart = 0.6;
// Metres that two submaps may be off where they are aligned: what drift leaves of a rigid fit, and
// of what was refined before or is known well. Wider, walls are paired with their neighbours.
inline constexpr double kSubmapGateM = 2.0, kKnownGateM = 1.0;
// Metres, and over pose_graph::kLeverM radians: submaps that moved by more are compared anew.
inline constexpr double kMovedM = 0.1;
// Alignments of a place within so many metres and radians are one.
inline constexpr double kSameShiftM = 1.0, kSameTurnRad = 0.09;

// Alignment of two submaps.

// Rounds; and metres, and over pose_graph::kLeverM radians: a step below ends them.
inline constexpr int kAlignmentRounds = 12;
inline constexpr double kAlignmentStepM = 0.002;
// Pairs of points without which two submaps are not aligned: about an eighth of
// kAlignedPoints. Fewer hold by chance.
inline constexpr size_t kMinAlignedPairs = 120;
// Pairs that are taken to err independently, whatever their number: errors of a scan's points go
// together. More makes edges stiffer than odometry and strains of right matches large.
inline constexpr double kIndependentPairs = 10;
// Points of a submap that are asked about its agreement; and metres from a map's surface within
// which they count as seen by it.
inline constexpr size_t kMaxAgreementPoints = 1500;
inline constexpr float kSeenM = 1.0f;

// Decision.

// Share contradicted below which a right and a wrong hypothesis are noise:
// MatcherOptions::min_margin is taken of no less.
inline constexpr double kFreeSpaceNoise = 0.002;
// A rival place is tighter with at least this share of the best one's inliers, an inlier ratio at
// most so much lower, and no more contradicted than the right place of a yard whose containers were
// moved, a quarter, or a wood, half. Of 22 tuned wild worlds this refused both wrong merges and 3
// of 18 right ones; a refused merge waits for more, a wrong one destroys a map.
inline constexpr double kMinTighterShare = 0.2, kTighterRatioSlack = 0.2,
                        kMaxTighterViolation = 0.5;
// Square metres from which on the share of MatcherOptions::max_enclosed_share rises: halls of 660
// m2 (twins_large) are still refused.
inline constexpr double kEnclosedFromM2 = 400;
// Confidence is multiplied by the first where the place may be a twin's, which of two is the right
// one being a guess, and by the second where it is contradicted: a wall that was looked through
// stands there only if a limit is wrong.
inline constexpr double kTwinConfidence = 0.5, kContradictedConfidence = 0.1;

}  // namespace isthmus::matching
