#include "server/matching/loops/loop_candidates.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/matching/loops/limits.h"

namespace isthmus::matching {
namespace {

// Equally near ones: newest, oldest, second newest, ...
void SortByNearness(std::vector<LoopCandidate>* candidates) {
  const auto step = [](const LoopCandidate& c) { return std::floor(c.apart_m / kNearnessStepM); };
  std::stable_sort(candidates->begin(), candidates->end(), [&](const auto& x, const auto& y) {
    return step(x) != step(y) ? step(x) < step(y) : x.position > y.position;
  });
  std::vector<LoopCandidate> sorted;
  for (size_t first = 0, last = 0; first < candidates->size(); first = last) {
    const double here = step((*candidates)[first]);
    while (last < candidates->size() && step((*candidates)[last]) == here) ++last;
    for (size_t newer = first, older = last; newer < older;) {
      sorted.push_back((*candidates)[newer++]);
      if (newer < older) sorted.push_back((*candidates)[--older]);
    }
  }
  *candidates = std::move(sorted);
}

}  // namespace

LoopCandidate CandidateAt(const LoopScene& scene, const LoopOptions& options, size_t position) {
  const KnownPose& known = scene.known[position];
  const Eigen::Vector3d middle = MiddleOf(*scene.newest());
  LoopCandidate candidate{position, known.T_new_old};
  candidate.apart_m = (known.T_new_old * MiddleOf(*scene.submaps[position]) - middle).norm();
  candidate.reach_m = options.drift_sigmas * known.PositionSigma(middle);
  candidate.reach_rad = options.drift_sigmas * known.RotationSigma();
  return candidate;
}

std::vector<LoopCandidate> FindLoopCandidates(const LoopScene& scene, const LoopOptions& options,
                                              const LoopSubmaps& submaps, size_t limit) {
  const double radius = submaps.Radius(scene.newest()->id.index, 0);
  std::vector<LoopCandidate> candidates;
  for (size_t i = 0; i + 1 < scene.submaps.size(); ++i) {
    const double path_length = scene.path_lengths.back() - scene.path_lengths[i];
    if (path_length < options.min_path_length_m) break;
    const LoopCandidate candidate = CandidateAt(scene, options, i);
    const double nearest = std::max(0.0, candidate.apart_m - kReachShare * candidate.reach_m);
    const double other = submaps.Radius(scene.submaps[i]->id.index, radius);
    if (nearest > kMaxLoopApart * (radius + other) || path_length < kPathPerApart * nearest)
      continue;
    candidates.push_back(candidate);
  }
  SortByNearness(&candidates);
  if (candidates.size() > limit) candidates.resize(limit);
  return candidates;
}

std::vector<LoopCandidate> FirstOfEachPass(const std::vector<LoopCandidate>& candidates,
                                           const LoopScene& scene, double path_length_m) {
  std::vector<LoopCandidate> first;
  for (const LoopCandidate& candidate : candidates) {
    const bool passed = std::any_of(first.begin(), first.end(), [&](const LoopCandidate& other) {
      return std::abs(scene.path_lengths[other.position] - scene.path_lengths[candidate.position]) <
             path_length_m;
    });
    if (!passed) first.push_back(candidate);
  }
  return first;
}

}  // namespace isthmus::matching
