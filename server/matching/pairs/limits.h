// Limits of matching pairs beside those of acceptance, which are MatcherOptions: which hypotheses
// are worth what, and when they count as one.
//
// Where no source is named a number is a guess that was never varied by itself. All of them
// together were in view on merging_benchmark's seeds 11 to 20 and held on 21 to 30
// (lab/docs/merging.md).
#pragma once

#include <cstddef>
#include <cstdint>

namespace isthmus::matching {

// Hypotheses that are worth a closer look.

// Radians, 11 degrees: maps are levelled, and what stands more askew to gravity is no merge of
// them.
inline constexpr double kMaxTiltRad = 0.2;
// A first look: the guesses by structure, and of so many by places, that are refined; and what one
// of them must have, less for loose surfaces: so much support, or, of robots that hardly moved, so
// many agreements of which hardly any is contradicted. Of merging_benchmark's wild worlds of seeds
// 3645 and 46296, on which they were chosen, 112 of 118 pairs had it that a search in full accepts,
// and one in six strangers.
inline constexpr size_t kFirstLooks = 2, kFirstPlaces = 12;
inline constexpr double kLeastFirstSupport = 300;
inline constexpr double kLeastFirstAgreements = 60, kHardlyContradicted = 0.15;
// Share of the best one's score or support below which a hypothesis is no rival: a twin scores half
// of it and more. Larger could leave a twin out, and then the pair would be believed.
inline constexpr double kMinRivalShare = 0.1;
// Guesses from places that look alike, of whole maps and of new submaps.
inline constexpr size_t kPlaceGuesses = 4, kNewPlaceGuesses = 2;
// Times the agreement of a hypothesis from which on another at its place replaces it. Less computes
// the free space of the same anew.
inline constexpr double kBetterAgreement = 1.1;
// Hypotheses that are refined jointly, the dearest step: each takes a quarter of a second. And what
// the share that is contradicted takes from the promise of a rigid alignment, of which drift
// contradicts right ones too. Chosen on 31 pairs of wild worlds whose right place was proposed
// (seeds 9240 to 9252 and 9603 to 9615): among four it was in 30 of them.
inline constexpr size_t kMaxJoint = 4;
inline constexpr double kPromiseOfFree = 30;
// Largest share contradicted, and fewest comparisons, of a guess of new submaps for which the whole
// is searched. Stricter, a meeting is found only when the maps have grown by a quarter.
inline constexpr double kMaxGuessViolation = 0.08;
inline constexpr int64_t kMinGuessComparisons = 500;
// Growth after which an accepted pair is searched elsewhere too; open ones are by kNewMapGrowth.
inline constexpr double kAcceptedGrowth = 2.0;

// Probability of what was found below which the paper's features are searched too, the dearest
// search: a guess.
inline constexpr double kLikely = 0.5;

// Hypotheses that are moved by what maps repeat, ways of repeating of each map, and the share of
// the overlap, at a first look, from which on it is done. Guesses.
inline constexpr size_t kMaxRepeated = 2, kMaxRepeats = 2;
inline constexpr double kMinRepeatedOverlap = 0.5;

// Joint refinement.

// Submaps of the other map that each is aligned with, and how far apart their middles may be, as a
// share of their radii. Fewer edges hold less against drift; farther ones have little in common.
inline constexpr size_t kPartners = 4;
inline constexpr double kMaxPartnersApart = 0.6;
// Submaps of either map from edge to edge of one stretch: where maps lie side by side each submap
// has partners, and one or two that could not be aligned end no stretch.
inline constexpr uint32_t kStretchSubmaps = 3;
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

// Anchors.

// Metres: side and height of the site anywhere on which a map could lie if its anchors were not
// known. A guess, as it hardly matters: see kMostByAnchors.
inline constexpr double kSiteM = 100, kSiteHeightM = 10;
// Metres of standard deviation from which on an anchor says nothing: of two such the evidence would
// be against any place of a site as large as that, sqrt(kSiteM^2 / (4 pi)) and likewise.
inline constexpr double kVagueM = 28, kVagueHeightM = 2.8;
// Metres and radians: no map is better than that, whatever is said of a point of it.
inline constexpr double kLeastSigmaM = 0.05, kLeastSigmaRad = 0.003;
// Log odds that anchors may add, odds of 20: a receiver's errors go together, and what lies a rack
// beside the right place is as near to the anchors. A guess.
inline constexpr double kMostByAnchors = 3;
// Log odds by anchors, odds of 10, from which on a twin of an enclosed place is out of the
// question. A guess.
inline constexpr double kTellsTwins = 2.3;
// Log odds below which a place is looked at only where there is no other.
inline constexpr double kRefutedByAnchors = -8;
// Error of odometry at some distance from an anchor: share of it, and radians per metre (0.01
// degrees). Less takes right places in long tunnels for refuted. Guesses.
inline constexpr double kAnchoredDrift = 0.02, kAnchoredTurn = 1.7e-4;
// Concentration of a heading, 1 / (15 degrees)^2, from which on it is known well enough for a
// guess.
inline constexpr double kKnownHeading = 15;
// Steps and reach in which better places are looked for about a guess, metres and radians; how many
// are refined. Refinement finds its way over a metre or two.
inline constexpr double kAnchorStepM = 2, kAnchorReachM = 10, kAnchorTurnRad = 0.07;
inline constexpr int kAnchorTurns = 2;
inline constexpr size_t kAnchorGuesses = 3;
// Metres by which anchors must move a guess for it to be searched again.
inline constexpr double kOtherGuessM = 3;

// Decision.

// Log odds of a right hypothesis of which all measures are typical: fitted, see probability.cc.
inline constexpr double kTypicalLogOdds = 4.349;
// Against one of two sensors' hanging, odds of 150: a guess. Halls turned over, floor on ceiling,
// are the last wrong ones, the best of them with odds of 100.
inline constexpr double kUpsideDownLogOdds = 5;
// Square metres up to which, under a roof, common ground has to be furnished to be evidence; and
// those that say nothing, so that next to no ground is no well furnished place. Of four such values
// the one that told right from wrong best.
inline constexpr double kRoomsM2 = 316, kNoRoomM2 = 80;
// Points that are distinctive, things that are in both where rooms are shared, and share of what
// stands upright that is seen again, against each session's own: nothing right was probable with
// much less (51, 4, and 0.36), so that what the fit says there is a guess.
inline constexpr int64_t kLeastThings = 3;
inline constexpr int64_t kLeastDistinctive = 40;
inline constexpr double kLeastUprightOfOwn = 0.4;
// Log odds beyond which nothing is more certain: keeps exp() finite.
inline constexpr double kMaxLogOdds = 40;
// Metres and shares that a session's own surfaces are taken to be no better than, and that others
// may be better than these: what a session of a few submaps says of itself is a guess. Two sessions
// of one submap each say nothing of themselves: theirs are taken to be as good as that, because
// with what is usual a flat and its mirror image were merged at 97 %.
inline constexpr double kLeastOwnResidualM = 0.025, kLeastOwnUpright = 0.3, kMostUpright = 1.1;
// Share as which no agreement counts, and share of regions contradicted at right places. Guesses.
inline constexpr double kNoUpright = 0.1, kRegionNoise = 0.005;
// Comparisons and contradictions that say little; powers of ten, of comparisons for each
// contradiction, from which on nothing was moved, and how many more make no difference. Of six such
// curves the one that told right from wrong best.
inline constexpr double kFewComparisons = 300, kFewContradictions = 3;
inline constexpr double kCleanFrom = 2.7, kMostClean = 0.5;
// Probability below which what is contradicted is rejected, and counts against others; and the
// share contradicted of so many comparisons that nothing right ever was: of 168 right places of
// worlds where loose things were moved between two days, the most was 22 %.
inline constexpr double kRejectedBelow = 0.02;
inline constexpr double kRefutedShare = 0.3;
inline constexpr int64_t kRefutedComparisons = 10'000;
// Ground that both know is enclosed beyond this share of what the robot knows that knows more,
// unless twins are rare; where they are possible only, the share rises to all of it over these
// square metres. Halls of 660 m2 (twins_large) are still refused then.
inline constexpr double kMaxEnclosedShare = 0.6;
inline constexpr double kEnclosedFromM2 = 400, kEnclosedToM2 = 1000;
// The probability that it is this place and not its twin, where all that is shared is enclosed:
// which of two is the right one is a guess. No map shows how many twins a place has.
inline constexpr double kTwinProbability = 0.5;

}  // namespace isthmus::matching
