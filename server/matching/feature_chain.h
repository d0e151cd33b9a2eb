// The paper's search for the transform between two maps with no initial guess (section 3.2): voxel
// filter, outlier removal, normals, Harris 3D key points, FPFH, reciprocal k-nearest matching,
// RANSAC and SVD.
#pragma once

#include <absl/status/statusor.h>

#include <vector>

#include "core/match.h"
#include "core/submap.h"
#include "server/matching/candidate.h"

namespace isthmus::matching {

struct FeatureChainOptions;  // Every stage's parameters, with units: feature_chain_options.h

// At most a few candidates, best first; empty when RANSAC finds no consensus. Candidate::score is
// the number of RANSAC inliers. Appends one entry per stage to `stages`. Deterministic. Both maps
// need at least one submap. Thread safe (no shared state).
std::vector<Candidate> SearchByFeatures(const SessionMap& a, const SessionMap& b,
                                        const FeatureChainOptions& options,
                                        std::vector<StageTime>* stages);

}  // namespace isthmus::matching
