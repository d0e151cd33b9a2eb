#include "server/matching/search/birds_eye.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/stopwatch.h"
#include "server/matching/registration/limits.h"
#include "server/matching/search/birds_eye_image.h"
#include "server/matching/search/limits.h"
#include "server/matching/search/planar_pose.h"
#include "server/matching/search/planar_score.h"
#include "server/matching/search/planar_search.h"

namespace isthmus::matching {
namespace {

PlanarPose Polish(const PlanarScore& scores, const BirdsEyeCells& b, PlanarPose pose,
                  double yaw_step, double shift_step) {
  const auto score = [&](const PlanarPose& at, double least) { return scores.Of(at, least); };
  pose.score = score(pose, -std::numeric_limits<double>::infinity());
  return Climb(pose, b.center.cast<double>(), yaw_step, shift_step, 0.5 * b.cell_m, score);
}

}  // namespace

SceneScale PairScale(const WallMap& a, const WallMap& b) {
  return a.outdoors() || b.outdoors() ? SceneScale::Outdoors() : SceneScale::Indoors();
}

std::vector<Candidate> SearchBirdsEye(const WallMap& a, const WallMap& b,
                                      const BirdsEyeOptions& options,
                                      std::vector<StageTime>* stages) {
  const Stopwatch watch;
  const SceneScale scale = PairScale(a, b);
  const double cell = options.cell_m > 0 ? options.cell_m : scale.cell_m;
  const double coarse_cell = CellThatFits(a, b, scale, kCoarseFactor * cell);
  const BirdsEyeCells a_coarse = MakeBirdsEyeCells(a, scale, coarse_cell);
  const bool is_own = &a == &b;
  const BirdsEyeCells b_coarse = is_own ? a_coarse : MakeBirdsEyeCells(b, scale, coarse_cell);
  std::vector<Candidate> candidates;
  if (!a_coarse.walls.empty() && !b_coarse.walls.empty()) {
    const double fine_cell = coarse_cell / kCoarseFactor;
    const Eigen::Vector2d pivot = b_coarse.center.cast<double>();
    const double apart = 4 * coarse_cell;
    std::vector<PlanarPose> poses =
        SuppressNeighbors(SearchPlanar(MakeReferenceImage(a_coarse, options.free_space_weight),
                                       b_coarse, {options.yaw_step_rad, false, options.stop}),
                          pivot, apart, kSuppressYawRad, kPolishedPlacements);
    const BirdsEyeCells a_fine = MakeBirdsEyeCells(a, scale, fine_cell);
    const BirdsEyeCells b_fine = is_own ? a_fine : MakeBirdsEyeCells(b, scale, fine_cell);
    const BirdsEyeImage reference = MakeReferenceImage(a_fine, options.free_space_weight);
    const PlanarScore scores(reference, b_fine, kFreeStride);
    for (PlanarPose& pose : poses) {
      if (options.stop.stop_requested()) return {};
      pose = Polish(scores, b_fine, pose, 0.5 * options.yaw_step_rad, coarse_cell);
    }
    poses = SuppressNeighbors(std::move(poses), pivot, apart, kSuppressYawRad,
                              static_cast<size_t>(std::max(0, options.candidates)));
    for (const PlanarPose& pose : poses) {
      candidates.push_back(ToCandidate(a, b, pose, GuessSource::kBirdsEye));
    }
  }
  if (stages) stages->push_back({"birds_eye", watch.Ms()});
  return candidates;
}

}  // namespace isthmus::matching
