#include "server/matching/pairs/decision.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>

#include "server/matching/pairs/limits.h"
#include "server/matching/pairs/probability.h"

namespace isthmus::matching {
namespace {

// The reason against accepting one hypothesis taken by itself; kOk for nothing.
struct Finding {
  MatchState state = MatchState::kAccepted;
  MatchReason reason = MatchReason::kOk;
  std::string detail;
};

double MaxEnclosedShare(double area_m2, Twins twins) {
  if (twins == Twins::kRare) return 1;
  if (twins == Twins::kExact) return kMaxEnclosedShare;
  const double risen = (area_m2 - kEnclosedFromM2) / (kEnclosedToM2 - kEnclosedFromM2);
  return kMaxEnclosedShare + (1 - kMaxEnclosedShare) * std::clamp(risen, 0.0, 1.0);
}

// All that is shared is enclosed, so that a place built alike would fit as well, and no anchors say
// that it is this one.
bool MayBeTwin(const Hypothesis& h, Twins twins) {
  return h.shared_share > MaxEnclosedShare(h.shared_area_m2, twins) && h.at_anchors < kTellsTwins;
}

// Common ground that is no larger is told from other such by things, not by walls.
bool IsInRooms(const Hypothesis& h) { return !h.outdoors && h.shared_area_m2 < kRoomsM2; }

bool HasFewThings(const Hypothesis& h) {
  return h.things.there < kLeastThings || h.things.gone > h.things.there;
}

// Too little tells the place from those that the maps repeat, and anchors do not either.
bool IsIndistinct(const Hypothesis& h) {
  const bool lacks = IsInRooms(h) ? HasFewThings(h) : h.distinctive < kLeastDistinctive;
  return lacks && h.by_anchors < kTellsTwins;
}

bool IsRefuted(const FreeSpaceScore& score) {
  return score.comparisons() >= kRefutedComparisons && score.violation() > kRefutedShare;
}

Finding LacksTightness(const Hypothesis& h, const std::string& rate) {
  const std::string own = h.own.on > 0
                              ? absl::StrFormat("within %.0f mm", 1000 * h.own.residual_m())
                              : "is not known before it has two submaps";
  return {MatchState::kNotYet, MatchReason::kLoose,
          absl::StrFormat("%s: surfaces lie on each other within %.0f mm, each robot's own %s.",
                          rate, 1000 * h.residual_m, own)};
}

Finding LacksGround(const Hypothesis& h, const std::string& rate) {
  const std::string things =
      h.outdoors ? "" : absl::StrFormat(" and %d things that stand there", h.things.there);
  return {MatchState::kNotYet, MatchReason::kTooSmall,
          absl::StrFormat("%s: the maps share only %.0f m2 of ground%s.", rate, h.shared_area_m2,
                          things)};
}

Finding LacksAgreement(const Hypothesis& h, const std::string& rate) {
  return {MatchState::kNotYet, MatchReason::kLowOverlap,
          absl::StrFormat("%s: of what stands upright where the maps meet, %.0f %% is in both; of "
                          "each robot's own %.0f %%.",
                          rate, 100 * h.upright_ratio, 100 * h.own.upright_ratio())};
}

Finding LacksDistinction(const Hypothesis& h, const std::string& rate) {
  if (h.repetition < kMinRepeatDegree) {
    return {MatchState::kNotYet, MatchReason::kLowOverlap,
            absl::StrFormat("%s: of what stands upright only %d points are in both maps.", rate,
                            h.distinctive)};
  }
  return {MatchState::kAmbiguous, MatchReason::kPossibleTwin,
          absl::StrFormat("%s: one of the maps lies on itself elsewhere %.0f %% as well as in its "
                          "place, and of what is in both only %d points tell this place from such.",
                          rate, 100 * h.repetition, h.distinctive)};
}

Finding LacksThings(const Hypothesis& h, const std::string& rate) {
  const bool moved = h.things.gone > h.things.there;
  return {MatchState::kNotYet, moved ? MatchReason::kFreeSpace : MatchReason::kTooSmall,
          absl::StrFormat("%s: the maps share %.0f m2. Of the things that stand there, %d are in "
                          "both; where %d others stand, one of the robots looked through.",
                          rate, h.shared_area_m2, h.things.there, h.things.gone)};
}

// The weakest point of a hypothesis that nothing else competes with.
Finding ExplainLack(const Hypothesis& h, double probability, const MatcherOptions& options) {
  const std::string rate = absl::StrFormat("%.1f %% probable where %.1f %% are needed",
                                           100 * probability, 100 * options.min_probability);
  const double violation = 100 * h.free_space.violation();
  switch (MeasureLogOdds(h).Weakest()) {
    case Term::kTightness:
      return LacksTightness(h, rate);
    case Term::kAgreement:
      return LacksAgreement(h, rate);
    case Term::kFreeSpace:
      return {probability < kRejectedBelow ? MatchState::kRejected : MatchState::kNotYet,
              MatchReason::kFreeSpace,
              absl::StrFormat("%s: one robot looked through what is a wall to the other in %.1f %% "
                              "of %d comparisons, in %d of %d regions most of it.",
                              rate, violation, h.free_space.comparisons(),
                              h.free_space.contradicted_regions, h.free_space.regions)};
    case Term::kGround:
      return LacksGround(h, rate);
    case Term::kAnchors:
      return {
          MatchState::kAmbiguous, MatchReason::kAmbiguous,
          absl::StrFormat("%s: the robots' anchors say that they are elsewhere (log odds %.1f). "
                          "Correct the anchors if they are wrong.",
                          rate, h.by_anchors)};
    case Term::kThings:
      return LacksThings(h, rate);
    case Term::kDistinctive:
      break;
  }
  if (h.upside_down) {
    return {MatchState::kAmbiguous, MatchReason::kPossibleTwin,
            absl::StrFormat("%s: one robot would hang from the other's ceiling, and a hall turned "
                            "over fits its mirror image.",
                            rate)};
  }
  return LacksDistinction(h, rate);
}

// The finding on a hypothesis by itself. kOk: nothing is against it.
Finding Examine(const Hypothesis& h, const MatcherOptions& options) {
  if (!h.converged) {
    return {MatchState::kNotYet, MatchReason::kNotConverged,
            "The best alignment found did not settle."};
  }
  if (!h.can_be_refuted) {
    return {MatchState::kNotYet, MatchReason::kFewComparisons,
            "A map came without sensor positions: what its robot looked through is not known."};
  }
  const double probability = ProbabilityAlone(h);
  if (IsRefuted(h.free_space)) {
    return {MatchState::kRejected, MatchReason::kFreeSpace,
            absl::StrFormat("One robot looked through what is a wall to the other in %.0f %% of "
                            "%d comparisons.",
                            100 * h.free_space.violation(), h.free_space.comparisons())};
  }
  if (probability < options.min_probability) return ExplainLack(h, probability, options);
  if (MayBeTwin(h, options.twins)) {
    return {
        MatchState::kAmbiguous, MatchReason::kPossibleTwin,
        absl::StrFormat("The %.0f m2 that both maps show are %.0f %% of what is known, more than "
                        "matching.twins allows here: a place built alike would fit as well. It "
                        "is decided when a robot sees more, by anchors, or by hand.",
                        h.shared_area_m2, 100 * h.shared_share)};
  }
  if (h.observability < options.min_observability) {
    return {MatchState::kNotYet, MatchReason::kDegenerate,
            absl::StrFormat(
                "The alignment can slide in one direction (observability %.4f where %.4f is "
                "needed), as along a bare corridor.",
                h.observability, options.min_observability)};
  }
  const std::string sure = absl::StrFormat("%.1f %% probable", 100 * probability);
  if (UprightOfOwn(h) < kLeastUprightOfOwn) return LacksAgreement(h, sure);
  if (IsIndistinct(h)) return IsInRooms(h) ? LacksThings(h, sure) : LacksDistinction(h, sure);
  if (h.odometry_residual > options.max_odometry_residual) {
    return {MatchState::kNotYet, MatchReason::kStrained,
            absl::StrFormat("The maps fit only if the odometry erred by %.1f of its standard "
                            "deviations where %.1f are allowed.",
                            h.odometry_residual, options.max_odometry_residual)};
  }
  return {};
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

// The probability, less if the place may be a twin's, which the maps cannot tell, or is a guess.
double Confidence(const Hypothesis& h, double probability, const MatcherOptions& options) {
  const bool is_guess = IsIndistinct(h) || UprightOfOwn(h) < kLeastUprightOfOwn;
  return probability * (MayBeTwin(h, options.twins) || is_guess ? kTwinProbability : 1);
}

// The report on a hypothesis that is not the best. A better one makes it no worse than ambiguous:
// other robots may tell which of two is right.
RivalMatch MakeRival(const Hypothesis& h, double probability, const MatcherOptions& options) {
  const Finding finding = Examine(h, options);
  RivalMatch rival;
  rival.T_a_b = h.T_a_b;
  const bool alone = finding.state == MatchState::kAccepted;
  rival.state = alone ? MatchState::kAmbiguous : finding.state;
  rival.reason = alone ? MatchReason::kAmbiguous : finding.reason;
  rival.confidence = Confidence(h, probability, options);
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
  const std::vector<double> probabilities = Probabilities(ranked);
  match->rivals.clear();
  for (size_t i = 1; i < ranked.size(); ++i) {
    match->rivals.push_back(MakeRival(ranked[i], probabilities[i], options));
  }
  if (ranked.size() > 1) match->runner_up = ranked[1].free_space.violation();
  Finding finding = Examine(best, options);
  if (finding.state == MatchState::kAccepted && probabilities[0] < options.min_probability) {
    finding = {MatchState::kAmbiguous, MatchReason::kAmbiguous,
               absl::StrFormat("%.1f %% probable where %.1f %% are needed, as the maps allow other "
                               "alignments; the next is %.1f %% probable.",
                               100 * probabilities[0], 100 * options.min_probability,
                               100 * probabilities[1])};
  }
  match->state = finding.state;
  match->reason = finding.reason;
  match->confidence = Confidence(best, probabilities[0], options);
  if (match->state == MatchState::kAccepted) {
    match->detail = absl::StrFormat(
        "%.1f %% probable: overlap %.0f %%, %.0f m2 shared, %.2f %% of %d free-space comparisons "
        "contradicted.",
        100 * match->confidence, 100 * match->overlap, best.shared_area_m2, 100 * match->free_space,
        match->comparisons);
    if (best.repetition >= kMinRepeatDegree && MayBeTwin(best, Twins::kExact)) {
      match->detail +=
          " The place is closed, and its world repeats itself: where whole places are built and "
          "furnished alike, set matching.twins to exact.";
    }
    return;
  }
  match->detail = finding.detail;
}

}  // namespace isthmus::matching
