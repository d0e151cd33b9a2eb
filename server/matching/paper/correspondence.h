// Correspondences between key points of two maps that look alike.
#pragma once

#include <vector>

#include "server/matching/paper/feature_chain_options.h"
#include "server/matching/paper/fpfh.h"

namespace isthmus::matching {

struct FeatureMatch {
  int a = 0, b = 0;  // Indices of descriptors.
  friend bool operator==(const FeatureMatch&, const FeatureMatch&) = default;
};

// All (i, j) where j is among the k nearest of i and i among the k nearest of j (Euclidean, ties to
// the lower index). Ascending by a, then b. Descriptors of zeros match nothing.
std::vector<FeatureMatch> MatchReciprocally(const std::vector<FpfhDescriptor>& a,
                                            const std::vector<FpfhDescriptor>& b,
                                            const CorrespondenceOptions& options);

}  // namespace isthmus::matching
