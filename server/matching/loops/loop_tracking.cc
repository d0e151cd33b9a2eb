#include "server/matching/loops/loop_tracking.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "server/matching/loops/limits.h"
#include "server/matching/loops/loop_confidence.h"
#include "server/matching/pairs/limits.h"
#include "server/matching/pairs/submap_alignment.h"
#include "server/matching/registration/limits.h"
#include "server/pose_graph/limits.h"
#include "server/pose_graph/optimize.h"
#include "server/pose_graph/problem.h"

namespace isthmus::matching {
namespace {

struct Laid {
  SubmapEdge edge;
  SurfaceAgreement agreement;
  FreeSpaceScore free_space;
};

std::optional<Laid> LayOn(const LoopScene& scene, const LoopCandidate& candidate,
                          const PreparedMap& fresh, const LoopOptions& options,
                          LoopSubmaps* submaps) {
  const std::shared_ptr<const PreparedMap> old =
      submaps->Prepared(scene.submaps[candidate.position]);
  const PreparedSubmap &a = *old->submaps().front(), &b = *fresh.submaps().front();
  const auto aligned =
      AlignSubmaps(a, b, candidate.T_new_old.Inverse(), std::min(candidate.reach_m, kSubmapGateM));
  if (!aligned) return std::nullopt;
  const Pose& T_a_b = aligned->T_a_b;
  const double chi2 = scene.known[candidate.position].Chi2(
      T_a_b.Inverse(), b.center(), kAlignmentErrorM, kAlignmentErrorM / pose_graph::kLeverM);
  if (chi2 > options.drift_sigmas * options.drift_sigmas) return std::nullopt;
  Laid laid;
  laid.edge = {a.submap().id.index, b.submap().id.index, T_a_b, aligned->information};
  laid.agreement =
      MeasureAgreement(b, T_a_b, old->submaps(), {Pose()}, Eigen::Vector3d::UnitZ(), kOnSurfaceM);
  const bool outdoors = IsOutdoors(*old) && IsOutdoors(fresh);
  laid.free_space = ScoreFreeSpace(old->free_space(), fresh.free_space(), {{Pose()}, {T_a_b}},
                                   FreeSpaceOptions::For(outdoors));
  const double limit = outdoors ? options.max_free_space_outdoors : options.max_free_space;
  const bool agrees = laid.free_space.violation() <= limit &&
                      laid.free_space.comparisons() * kComparisonShare >= options.min_comparisons &&
                      static_cast<double>(laid.agreement.on) >=
                          options.min_overlap * static_cast<double>(laid.agreement.asked);
  if (!agrees) return std::nullopt;
  return laid;
}

// True if the newest submap lies the same by both.
bool Agree(const LoopScene& scene, size_t position, const Laid& laid, size_t other_position,
           const Laid& other) {
  const auto T_new = [&](size_t i) { return scene.known[i].T_new_old; };
  const Pose T_old_old = T_new(position).Inverse() * T_new(other_position);
  const Pose apart = laid.edge.T_a_b.Inverse() * T_old_old * other.edge.T_a_b;
  return apart.translation().norm() < kAgreeM &&
         RotationAngle(apart) < kAgreeM / pose_graph::kLeverM;
}

// Candidates with fewer than kEdgesPerPass edges come right after the first: retired submaps take
// their edges along, and a submap that no loop holds any more lies where odometry has it.
std::vector<LoopCandidate> LonelyFirst(const LoopScene& scene,
                                       const std::vector<LoopCandidate>& candidates) {
  std::vector<int> held(scene.submaps.size(), 0);
  for (const LoopEdge& edge : scene.edges) {
    ++held[edge.a];
    ++held[edge.b];
  }
  std::vector<LoopCandidate> sorted = candidates;
  if (!sorted.empty()) {
    std::stable_partition(sorted.begin() + 1, sorted.end(), [&](const LoopCandidate& candidate) {
      return held[candidate.position] < kEdgesPerPass;
    });
  }
  return sorted;
}

LoopClosure Close(const std::vector<Laid>& laid, const LoopScene& scene) {
  LoopClosure closure;
  const Laid& first = laid.front();
  closure.session = scene.newest()->id.session;
  closure.submap_a = first.edge.submap_a;
  closure.submap_b = first.edge.submap_b;
  closure.T_a_b = first.edge.T_a_b;
  SurfaceAgreement agreement;
  FreeSpaceScore free_space;
  for (const Laid& one : laid) {
    closure.edges.push_back(one.edge);
    agreement += one.agreement;
    free_space += one.free_space;
  }
  const auto on = static_cast<double>(agreement.on);
  closure.overlap = on / static_cast<double>(std::max<int64_t>(agreement.asked, 1));
  closure.residual_m = std::sqrt(agreement.squared_m2 / std::max(on, 1.0));
  closure.free_space = free_space.violation();
  closure.comparisons = free_space.comparisons();
  closure.source = GuessSource::kOdometry;
  return closure;
}

bool AllAgree(const LoopScene& scene, const std::vector<size_t>& taken,
              const std::vector<Laid>& laid) {
  for (size_t i = 1; i < laid.size(); ++i) {
    if (!Agree(scene, taken[0], laid[0], taken[i], laid[i])) return false;
  }
  return true;
}

double MaxFreeSpace(const PreparedMap& fresh, const LoopOptions& options) {
  return IsOutdoors(fresh) ? options.max_free_space_outdoors : options.max_free_space;
}

// By more than alignments err.
bool ContradictsOdometry(const LoopScene& scene, size_t position, const SubmapEdge& edge) {
  const Vector6d error = pose_graph::EdgeError(scene.submaps[position]->T_odom_submap,
                                               scene.newest()->T_odom_submap, edge.T_a_b);
  return error.dot(edge.information * error) > pose_graph::Options().doubt_chi2;
}

}  // namespace

bool IsKnownWell(const LoopCandidate& candidate) {
  return candidate.reach_m < kSubmapGateM &&
         candidate.reach_rad < kSubmapGateM / pose_graph::kLeverM;
}

std::optional<LoopClosure> FollowLoop(const LoopScene& scene,
                                      const std::vector<LoopCandidate>& candidates,
                                      const LoopOptions& options, LoopSubmaps* submaps) {
  const std::shared_ptr<const PreparedMap> fresh = submaps->Prepared(scene.newest());
  std::vector<Laid> laid;
  std::vector<size_t> taken;
  double reach = 0;
  size_t tried = 0;
  for (const LoopCandidate& candidate : LonelyFirst(scene, candidates)) {
    if (laid.size() >= options.max_edges || tried >= options.max_edges + 2) break;
    const auto of_this_pass = std::count_if(taken.begin(), taken.end(), [&](size_t position) {
      return std::abs(scene.path_lengths[position] - scene.path_lengths[candidate.position]) <
             options.min_path_length_m;
    });
    if (!IsKnownWell(candidate) || of_this_pass >= kEdgesPerPass) continue;
    ++tried;
    std::optional<Laid> one = LayOn(scene, candidate, *fresh, options, submaps);
    if (!one) continue;
    laid.push_back(std::move(*one));
    taken.push_back(candidate.position);
    reach = std::max(reach, candidate.reach_m);
  }
  if (laid.empty() || (laid.size() == 1 && reach > kAloneM)) return std::nullopt;
  if (!AllAgree(scene, taken, laid)) return std::nullopt;
  LoopClosure closure = Close(laid, scene);
  DescribeLoop(MaxFreeSpace(*fresh, options), CameBack(closure), &closure);
  return closure;
}

std::optional<LoopClosure> FollowSteps(const LoopScene& scene, const LoopOptions& options,
                                       LoopSubmaps* submaps) {
  const std::shared_ptr<const PreparedMap> fresh = submaps->Prepared(scene.newest());
  std::vector<Laid> laid;
  std::vector<size_t> taken;
  bool is_bad = false;
  const size_t newest = scene.submaps.size() - 1;
  for (size_t back = 1; back <= std::min(kStepsBack, newest); ++back) {
    const size_t position = newest - back;
    const double path_length = scene.path_lengths[newest] - scene.path_lengths[position];
    if (path_length >= options.min_path_length_m) break;
    const LoopCandidate candidate = CandidateAt(scene, options, position);
    if (!IsKnownWell(candidate)) break;
    std::optional<Laid> one = LayOn(scene, candidate, *fresh, options, submaps);
    if (!one) continue;
    is_bad |= ContradictsOdometry(scene, position, one->edge);
    laid.push_back(std::move(*one));
    taken.push_back(position);
  }
  if (!is_bad || !AllAgree(scene, taken, laid)) return std::nullopt;
  LoopClosure closure = Close(laid, scene);
  const Pose T_odom_a_b =
      scene.submaps[taken.front()]->T_odom_submap.Inverse() * scene.newest()->T_odom_submap;
  const double off_m = (T_odom_a_b.Inverse() * closure.T_a_b).translation().norm();
  DescribeLoop(MaxFreeSpace(*fresh, options),
               absl::StrFormat("Odometry errs by %.2f m from submap %d to submap %d", off_m,
                               closure.submap_a, closure.submap_b),
               &closure);
  return closure;
}

}  // namespace isthmus::matching
