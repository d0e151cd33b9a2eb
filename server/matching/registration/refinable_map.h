// The contents of a RefinableMap, for the files that refine and measure alignments.
#pragma once

#include <vector>

#include "server/matching/registration/kd_tree.h"
#include "server/matching/registration/refine.h"
#include "server/matching/registration/surface.h"
#include "server/matching/registration/vgicp.h"

namespace isthmus::matching {

struct RefinableMap::Data {
  std::vector<SurfacePoint> points;
  double voxel_m = 0;              // Between points.
  KdTree tree;                     // Over points.
  GaussianVoxelMap voxels;         // Edge RefineOptions::vgicp_voxel_m.
  GaussianVoxelMap fine_voxels;    // Half that edge.
  std::vector<int> coarse_sample;  // Into points: what is moved while metres off,
  std::vector<int> fine_sample;    // and at the end.
};

}  // namespace isthmus::matching
