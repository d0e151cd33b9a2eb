// Fast point feature histograms: Rusu, Blodow, Beetz, "Fast Point Feature Histograms (FPFH) for 3D
// Registration", ICRA 2009.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/matching/paper/feature_chain_options.h"
#include "server/matching/paper/normals.h"

namespace isthmus::matching {

// Three histograms of eleven bins, each of sum 100.
using FpfhDescriptor = Eigen::Matrix<float, 33, 1>;

// One per key point (index into points), computed from all points. A key point without neighbours
// has a descriptor of zeros. May throw what PCL throws.
std::vector<FpfhDescriptor> DescribeFpfh(const OrientedPoints& points,
                                         const std::vector<int>& keypoints,
                                         const FpfhOptions& options);

}  // namespace isthmus::matching
