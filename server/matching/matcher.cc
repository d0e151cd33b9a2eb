#include "server/matching/matcher.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/stopwatch.h"
#include "server/matching/birds_eye.h"
#include "server/matching/birds_eye_image.h"
#include "server/matching/decision.h"
#include "server/matching/feature_chain.h"
#include "server/matching/feature_chain_options.h"
#include "server/matching/prepared_map.h"
#include "server/matching/shared_area.h"

namespace isthmus::matching {
namespace {

// Alignments nearer to each other than this, where the maps meet, are one hypothesis.
constexpr double kSameShiftM = 1.0, kSameTurnRad = 0.09;

// Maps are levelled: what stands this much askew to gravity after refinement is no merge of them. A
// building turned upside down fits its mirror image.
constexpr double kMaxTiltRad = 0.2;
// Of the chain's candidates, in the odom frames, each within about 10 degrees of level.
constexpr double kMaxOdomTiltRad = 0.4;

// Candidates of the bird's-eye search with less than this share of the best one's score are no
// rivals of it: a twin scores half of it and more.
constexpr double kMinScoreShare = 0.1;

// The shift between two transforms is taken at the place where b's points are.
bool IsSame(const Pose& T_a_b, const Pose& other_T_a_b, const Eigen::Vector3d& p_b) {
  return (T_a_b * p_b - other_T_a_b * p_b).norm() < kSameShiftM &&
         RotationAngle(T_a_b.Inverse() * other_T_a_b) < kSameTurnRad;
}

Eigen::Vector3d MeanSensor(const PreparedMap& map) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const auto& sensors = map.walls().sensors();
  for (const Eigen::Vector3f& sensor : sensors) sum += sensor.cast<double>();
  if (!sensors.empty()) sum /= static_cast<double>(sensors.size());
  return map.walls().T_level_odom().Inverse() * sum;
}

// The smallest eigenvalue of the translation's information about `center` (frame a) with the
// rotation free (Schur complement), per inlier and in units of one inlier's.
double WeakestHold(const Refinement& refinement, const Eigen::Vector3d& center) {
  if (refinement.inliers == 0) return 0;
  // A twist [rho; phi] about the origin moves the center by rho' = rho + phi x center.
  Matrix6d J = Matrix6d::Identity();
  J.topRightCorner<3, 3>() = Skew(center);
  const Matrix6d H = J.transpose() * refinement.information * J;
  const Eigen::Matrix3d rotation = H.bottomRightCorner<3, 3>();
  const Eigen::Matrix3d cross = H.topRightCorner<3, 3>();
  const Eigen::Matrix3d held =
      H.topLeftCorner<3, 3>() - cross * rotation.ldlt().solve(cross.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(held, Eigen::EigenvaluesOnly);
  // Every inlier adds n n^T to the trace, wherever it is: the trace is its weight.
  const double inlier_weight =
      H.topLeftCorner<3, 3>().trace() / static_cast<double>(refinement.inliers);
  const double least = solver.eigenvalues()[0];
  if (!(inlier_weight > 0) || !(least > 0)) return 0;
  return least / (inlier_weight * static_cast<double>(refinement.inliers));
}

// One pair's matching: what the searches propose, refined and verified, and what it took.
class PairMatcher {
 public:
  PairMatcher(const PreparedMap& a, const PreparedMap& b, const MatcherOptions& options)
      : a_(a), b_(b), options_(options), scale_(PairScale(a.walls(), b.walls())) {
    refine_options_ = a.refine_options();
    refine_options_.voxel_m = std::max(refine_options_.voxel_m, b.refine_options().voxel_m);
    if (scale_.outdoors) refine_options_.coarse_distance_m *= 1.5;
    middle_b_ = MeanSensor(b);
  }

  void SearchByBirdsEye(std::vector<StageTime>* stages) {
    std::vector<Candidate> candidates =
        SearchBirdsEye(a_.walls(), b_.walls(), BirdsEyeOptions(), stages);
    std::erase_if(candidates, [least = candidates.empty() ? 0 : candidates[0].score](
                                  const Candidate& c) { return c.score < kMinScoreShare * least; });
    Take(candidates, stages);
  }

  void SearchByChain(std::vector<StageTime>* stages) {
    FeatureChainOptions chain;
    chain.ransac.max_tilt_rad = kMaxOdomTiltRad;
    Take(SearchByFeatures(a_.session_map(), b_.session_map(), chain, stages), stages);
  }

  bool Indoors() const { return !scale_.outdoors; }
  const std::vector<Hypothesis>& hypotheses() const { return hypotheses_; }

 private:
  void Take(const std::vector<Candidate>& candidates, std::vector<StageTime>* stages) {
    Stopwatch watch;
    std::vector<Hypothesis> fresh;
    for (const Candidate& candidate : candidates) {
      Hypothesis h;
      h.source = candidate.source;
      h.refinement =
          RefineAlignment(a_.refinable(), b_.refinable(), candidate.T_a_b, refine_options_);
      if (h.refinement.T_a_b.IsFinite() && Tilt(h.refinement.T_a_b) < kMaxTiltRad) {
        fresh.push_back(std::move(h));
      }
    }
    stages->push_back({"refine", watch.Lap()});
    for (Hypothesis& h : fresh) {
      if (IsKnown(h)) continue;
      Verify(&h);
      hypotheses_.push_back(std::move(h));
    }
    RankHypotheses(&hypotheses_);
    stages->push_back({"verify", watch.Lap()});
  }

  // Angle between the two maps' verticals.
  double Tilt(const Pose& T_a_b) const {
    const Eigen::Vector3d up_b =
        b_.walls().T_level_odom().rotation().inverse() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d up_level = (a_.walls().T_level_odom() * T_a_b).rotation() * up_b;
    return std::acos(std::clamp(up_level.z(), -1.0, 1.0));
  }

  bool IsKnown(const Hypothesis& h) const {
    return std::any_of(hypotheses_.begin(), hypotheses_.end(), [&](const Hypothesis& other) {
      return IsSame(h.refinement.T_a_b, other.refinement.T_a_b, middle_b_);
    });
  }

  void Verify(Hypothesis* h) {
    if (a_cells_.cell_m == 0) {
      const double cell = 2 * scale_.cell_m;
      a_cells_ = MakeBirdsEyeCells(a_.walls(), scale_, cell);
      b_cells_ = MakeBirdsEyeCells(b_.walls(), scale_, cell);
    }
    const Pose& T_a_b = h->refinement.T_a_b;
    h->free_space = ScoreFreeSpace(a_.free_space(), b_.free_space(), T_a_b, FreeSpaceOptions());
    h->max_free_space =
        scale_.outdoors ? options_.max_free_space_outdoors : options_.max_free_space;
    const Pose& T_level_a = a_.walls().T_level_odom();
    const Pose T_b_level = b_.walls().T_level_odom().Inverse();
    const SharedArea shared = MeasureSharedArea(a_cells_, b_cells_, T_level_a * T_a_b * T_b_level);
    h->shared_area_m2 = shared.area_m2;
    h->weakest_hold = WeakestHold(h->refinement, T_level_a.Inverse() * shared.center);
  }

  const PreparedMap& a_;
  const PreparedMap& b_;
  const MatcherOptions& options_;
  const SceneScale scale_;
  RefineOptions refine_options_;
  Eigen::Vector3d middle_b_ = Eigen::Vector3d::Zero();
  BirdsEyeCells a_cells_, b_cells_;
  std::vector<Hypothesis> hypotheses_;  // Best first.
};

bool IsUndecided(const Match& match) {
  return match.state == MatchState::kNotYet || match.state == MatchState::kRejected;
}

}  // namespace

Match MatchPrepared(const PreparedMap& a, const PreparedMap& b, const MatcherOptions& options) {
  Match match;
  match.a = a.session_map().session;
  match.b = b.session_map().session;
  match.submaps_a = static_cast<uint32_t>(a.session_map().submaps.size());
  match.submaps_b = static_cast<uint32_t>(b.session_map().submaps.size());
  match.stages.push_back({"prepare", a.prepare_ms() + b.prepare_ms()});
  PairMatcher matcher(a, b, options);
  if (options.search != "paper") {
    matcher.SearchByBirdsEye(&match.stages);
    Decide(matcher.hypotheses(), options, &match);
  }
  const bool by_chain = options.search == "paper" ||
                        (options.search != "birds_eye" && matcher.Indoors() && IsUndecided(match));
  if (by_chain && match.submaps_a > 0 && match.submaps_b > 0) {
    matcher.SearchByChain(&match.stages);
    Decide(matcher.hypotheses(), options, &match);
  }
  return match;
}

Match MatchSessions(const SessionMap& a, const SessionMap& b, const MatcherOptions& options) {
  return MatchPrepared(PreparedMap(a), PreparedMap(b), options);
}

}  // namespace isthmus::matching
