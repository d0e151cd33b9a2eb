// The paper's search for the transform between two maps with no initial guess (section 3.2): voxel
// filter, outlier removal, normals, Harris 3D key points, FPFH, reciprocal k-nearest matching,
// RANSAC and SVD.
#pragma once

#include <absl/status/statusor.h>

#include <Eigen/Core>
#include <vector>

#include "core/map/match.h"
#include "core/map/submap.h"
#include "server/matching/paper/feature_chain_options.h"
#include "server/matching/paper/fpfh.h"
#include "server/matching/registration/candidate.h"

namespace isthmus::matching {

// The key points of one map and what their surroundings look like: computed once, matched against
// many.
struct FeatureSet {
  std::vector<Eigen::Vector3f> keypoints;   // Odom frame.
  std::vector<FpfhDescriptor> descriptors;  // One per key point.
};

// Everything that needs one map only. An empty set for a map without structure; Internal when PCL
// fails. Appends one entry per stage to `stages`.
absl::StatusOr<FeatureSet> ComputeFeatures(const SessionMap& map,
                                           const FeatureChainOptions& options,
                                           std::vector<StageTime>* stages);

// Everything that needs the pair. At most options.ransac.candidates, best first; empty when RANSAC
// finds no consensus. Appends one entry per stage to `stages`.
std::vector<Candidate> MatchFeatures(const FeatureSet& a, const FeatureSet& b,
                                     const FeatureChainOptions& options,
                                     std::vector<StageTime>* stages);

// Both of the above. At most a few candidates, best first; empty when RANSAC finds no consensus or
// PCL fails. Candidate::score is the number of RANSAC inliers. Appends one entry per stage to
// `stages`, both maps together. Deterministic. Thread safe (no shared state).
std::vector<Candidate> SearchByFeatures(const SessionMap& a, const SessionMap& b,
                                        const FeatureChainOptions& options,
                                        std::vector<StageTime>* stages);

}  // namespace isthmus::matching
