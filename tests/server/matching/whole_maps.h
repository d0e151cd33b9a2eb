// The stages of matching from bare maps, for tests that run one of them once.
#pragma once

#include <memory>
#include <vector>

#include "server/matching/pairs/matcher.h"
#include "server/matching/prepared/free_space.h"
#include "server/matching/prepared/prepared_map.h"
#include "server/matching/registration/refine.h"
#include "server/matching/registration/surface.h"
#include "server/matching/search/birds_eye.h"
#include "server/matching/search/gravity.h"
#include "server/matching/search/up_candidates.h"
#include "server/matching/search/wall_map.h"

namespace isthmus::matching {

inline Match MatchPrepared(const PreparedMap& a, const PreparedMap& b,
                           const MatcherOptions& options) {
  return PairMatcher(options).Update(a, b);
}

inline Match MatchSessions(const SessionMap& a, const SessionMap& b,
                           const MatcherOptions& options) {
  return MatchPrepared(PreparedMap(a), PreparedMap(b), options);
}

inline RefinableMap MakeRefinable(const SessionMap& map, const RefineOptions& options) {
  return RefinableMap(SampleSurface(map, options.voxel_m), options);
}

inline std::vector<Candidate> SearchBirdsEye(const SessionMap& a, const SessionMap& b,
                                             const BirdsEyeOptions& options,
                                             std::vector<StageTime>* stages) {
  return SearchBirdsEye(WallMap(a, SampleSurface(a, kIndoorVoxelM)),
                        WallMap(b, SampleSurface(b, kIndoorVoxelM)), options, stages);
}

inline FreeSpaceMap MakeFreeSpace(const SessionMap& map, const FreeSpaceOptions& options) {
  PreparedSubmaps submaps;
  for (const auto& submap : map.submaps) {
    submaps.push_back(std::make_shared<const PreparedSubmap>(submap));
  }
  double voxel_m = kIndoorVoxelM;
  const Pose T_level_odom(EstimateLevel(JoinSurfaces(submaps, 0, &voxel_m)),
                          Eigen::Vector3d::Zero());
  return FreeSpaceMap(submaps, T_level_odom, options);
}

inline FreeSpaceScore ScoreFreeSpace(const SessionMap& a, const SessionMap& b, const Pose& T_a_b,
                                     const FreeSpaceOptions& options) {
  return ScoreFreeSpace(MakeFreeSpace(a, options), MakeFreeSpace(b, options),
                        MapPoses::Rigid(a, b, T_a_b), options);
}

}  // namespace isthmus::matching
