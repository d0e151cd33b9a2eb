// The part of anchors in the match of a pair.
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "server/matching/pairs/limits.h"
#include "server/matching/pairs/matcher.h"
#include "server/matching/search/limits.h"

namespace isthmus::matching {

double PairMatcher::AtAnchors(const PreparedMap& a, const PreparedMap& b, const Pose& T_a_b) const {
  if (prior_.empty()) return 0;
  return prior_.LogOdds(MapPoses::Rigid(a.session_map(), b.session_map(), T_a_b));
}

bool PairMatcher::MustSearchAtAnchors(const PreparedMap& a, const PreparedMap& b) const {
  const std::optional<Pose> guess = prior_.Guess();
  if (!guess) return false;
  const bool found = std::any_of(memory_.hypotheses.begin(), memory_.hypotheses.end(),
                                 [&](const Hypothesis& h) { return AtAnchors(a, b, h.T_a_b) > 0; });
  const Eigen::Vector3d middle = b.whole().walls.MeanSensor();
  const bool searched = memory_.searched_guess &&
                        (*guess * middle - *memory_.searched_guess * middle).norm() < kOtherGuessM;
  return !found && !searched;
}

std::vector<Hypothesis> PairMatcher::SelectPromising(const PreparedMap& a, const PreparedMap& b,
                                                     std::vector<Hypothesis>* found) const {
  if (prior_.empty()) return MostPromising(found);
  const auto refuted = std::stable_partition(found->begin(), found->end(), [&](const auto& h) {
    return AtAnchors(a, b, h.T_a_b) > kRefutedByAnchors;
  });
  std::vector<Hypothesis> allowed(found->begin(), refuted), others(refuted, found->end());
  std::vector<Hypothesis> best = MostPromising(&allowed);
  // One that anchors refute is looked at as well: if it is good, they are wrong.
  const std::vector<Hypothesis> rest = MostPromising(&others);
  if (!rest.empty()) best.push_back(rest.front());
  return best;
}

void PairMatcher::WeighAnchors(const PreparedMap& a, const PreparedMap& b, Hypothesis* h) const {
  const MapPoses& poses = h->joint.poses;
  const double here = prior_.LogOdds(poses);
  // Against any place of the site, and under a roof the storeys above and below, which nobody need
  // have seen.
  double others = 1;
  const Eigen::Vector3d up = a.T_level_odom().rotation().inverse() * Eigen::Vector3d::UnitZ();
  for (const double storey : {-kMinStoreyM, kMinStoreyM}) {
    if (h->outdoors) continue;
    others += std::exp(prior_.LogOdds(poses, Pose(Eigen::Vector3d(storey * up))));
  }
  h->at_anchors = here - std::log(others);
  // Places that a map repeats are as near to the anchors too, and the right one among them may not
  // have been found; places that were found compete by themselves.
  const Eigen::Vector3d middle = b.whole().walls.MeanSensor();
  for (const Pose& T_a_b : MovedByRepeats(a, b, h->T_a_b)) {
    const bool found = std::any_of(
        memory_.hypotheses.begin(), memory_.hypotheses.end(),
        [&](const Hypothesis& other) { return IsSameAlignment(T_a_b, other.T_a_b, middle); });
    if (!found) others += std::exp(prior_.LogOdds(poses, T_a_b * h->T_a_b.Inverse()));
  }
  h->by_anchors = std::min({here, std::max(0.0, here - std::log(others)), kMostByAnchors});
}

}  // namespace isthmus::matching
