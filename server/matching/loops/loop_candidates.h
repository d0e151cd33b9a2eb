// Candidates for loop closures: older submaps that the newest may lie on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "server/matching/loops/loop_drift.h"
#include "server/matching/loops/loop_options.h"
#include "server/matching/loops/loop_submaps.h"

namespace isthmus::matching {

// A session as of one of its submaps, which is the last of `submaps`.
struct LoopScene {
  std::vector<std::shared_ptr<const Submap>> submaps;
  std::vector<Pose> T_map_submap;
  std::vector<double> path_lengths;  // PathLengths.
  std::vector<LoopEdge> edges;       // Edges of loops closed so far, as far as they are believed.
  std::set<std::pair<uint32_t, uint32_t>> joined;  // By index: all that were found, older first.
  std::vector<KnownPose> known;                    // Poses of all but the last, from the last.

  const std::shared_ptr<const Submap>& newest() const { return submaps.back(); }
};

struct LoopCandidate {
  size_t position = 0;  // In the scene's submaps.
  Pose T_new_old;       // By odometry and the loops so far, ...
  double apart_m = 0;   // ... the distance between the middles of the ways, ...
  double reach_m = 0;   // ... and how far off that may be.
  double reach_rad = 0;
};

LoopCandidate CandidateAt(const LoopScene& scene, const LoopOptions& options, size_t position);

// Submaps far enough back along the way that may overlap the newest: nearest first, in steps of
// some metres; of equally near ones the newest and the oldest in turn, so that a place that is seen
// again and again hangs on its latest and on its first look. At most `limit`.
std::vector<LoopCandidate> FindLoopCandidates(const LoopScene& scene, const LoopOptions& options,
                                              const LoopSubmaps& submaps, size_t limit);

// The first of each stretch of the way, in their order.
std::vector<LoopCandidate> FirstOfEachPass(const std::vector<LoopCandidate>& candidates,
                                           const LoopScene& scene, double path_length_m);

}  // namespace isthmus::matching
