#include "server/matching/prepared/self_similarity.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/near.h"
#include "server/matching/prepared/limits.h"
#include "server/matching/registration/limits.h"
#include "server/matching/search/birds_eye.h"

namespace isthmus::matching {

std::vector<Pose> SelfSimilarity::Moves(size_t most) const {
  std::vector<Pose> moves;
  for (size_t i = 0; i < std::min(repeats.size(), most); ++i) {
    if (repeats[i].degree < kMinRepeatDegree) break;
    moves.push_back(repeats[i].T_odom_odom);
    moves.push_back(repeats[i].T_odom_odom.Inverse());
  }
  return moves;
}

double TightOverlap(double overlap, double residual_m) {
  return overlap * std::max(0.0, 1 - residual_m / (kOnSurfaceM / std::sqrt(3.0)));
}

SelfSimilarity MeasureSelfSimilarity(const WallMap& walls, const RefinableMap& refinable,
                                     const RefineOptions& options) {
  // Moved to where the robot was, so that a turn is one about that and no shift.
  const Pose T_odom_middle(walls.MeanSensor());
  const auto in_middle = [&](const Pose& T) { return T_odom_middle.Inverse() * T * T_odom_middle; };
  std::vector<Pose> seen = {Pose()};
  const auto is_new = [&](const Pose& T) {
    return std::none_of(seen.begin(), seen.end(), [&](const Pose& other) {
      return AreNear(T, other, kRepeatShiftM, kRepeatTurnRad);
    });
  };
  const auto refine = [&](const Pose& T) {
    return RefineAlignment(refinable, refinable, T, options);
  };
  const Refinement itself = refine(Pose());
  const double in_place = TightOverlap(itself.overlap, itself.residual_m);
  SelfSimilarity found;
  if (in_place <= 0) return found;
  const std::vector<Candidate> candidates =
      SearchBirdsEye(walls, walls, BirdsEyeOptions(), nullptr);
  for (const Candidate& candidate : candidates) {
    if (candidate.score < kMinRepeatScore * candidates.front().score) break;
    if (!is_new(in_middle(candidate.T_a_b))) continue;
    const Refinement refined = refine(candidate.T_a_b);
    if (!refined.T_a_b.IsFinite() || !is_new(in_middle(refined.T_a_b))) continue;
    seen.push_back(in_middle(refined.T_a_b));
    const double degree = TightOverlap(refined.overlap, refined.residual_m) / in_place;
    found.repeats.push_back({refined.T_a_b, std::min(1.0, degree)});
  }
  std::stable_sort(found.repeats.begin(), found.repeats.end(),
                   [](const auto& x, const auto& y) { return x.degree > y.degree; });
  return found;
}

}  // namespace isthmus::matching
