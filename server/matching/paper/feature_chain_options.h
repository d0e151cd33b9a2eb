// Every parameter of the paper's feature chain. The lengths suit LiDAR maps of buildings and
// streets alike.
#pragma once

#include <cmath>
#include <cstdint>

namespace isthmus::matching {

struct VoxelFilterOptions {
  // Edge of a voxel. Coarser is faster and leaves fewer key points.
  double voxel_m = 0.3;
};

struct OutlierRemovalOptions {
  // The number of neighbours whose mean distance is taken.
  int neighbors = 12;
  // Points with a mean distance this many standard deviations above the map's mean are dropped.
  double max_deviations = 2.0;
};

struct NormalOptions {
  // Neighbourhood a plane is fitted to; about two voxels.
  double radius_m = 0.6;
};

struct HarrisOptions {
  // Neighbourhood whose normals make the response.
  double radius_m = 0.6;
  // Smallest response of a key point; more gives fewer points.
  double threshold = 1e-4;
  // The strongest are kept.
  int max_keypoints = 4000;
};

struct FpfhOptions {
  // The support of a descriptor. Must be larger than the normals' radius.
  double radius_m = 2.4;
  // Thinning of the points that are counted in it; key points and normals stay as fine as they
  // are. 0: none. The cost falls with the fourth power.
  double surface_voxel_m = 0.5;
};

struct CorrespondenceOptions {
  // i and j match when each is among this many nearest of the other.
  int nearest = 5;
};

struct RansacOptions {
  // Samples of three pairs drawn at the most; fewer once a consensus half the size of the best
  // would have been found.
  int iterations = 1000000;
  // About two voxels.
  double inlier_distance_m = 0.6;
  // Least ratio of the lengths of corresponding edges of a sample.
  double edge_similarity = 0.9;
  // Shorter edges fix no rotation.
  double min_edge_m = 3.0;
  // Largest angle between the maps' z axes; pi: gravity is not known.
  double max_tilt_rad = M_PI;
  // Fewer are no consensus.
  int min_inliers = 8;
  // Distinct consensus sets that are fitted, and those returned, distinct after the fit, at the
  // most.
  int hypotheses = 20;
  int candidates = 5;
  // Two transforms are distinct when they differ by this much or that.
  double distinct_m = 2.0;
  double distinct_rad = 0.17;
  // The seed of the sampling; equal seeds give equal results.
  uint64_t seed = 1;
};

struct FeatureChainOptions {
  VoxelFilterOptions voxel_filter;
  OutlierRemovalOptions outlier_removal;
  NormalOptions normals;
  HarrisOptions harris;
  FpfhOptions fpfh;
  CorrespondenceOptions correspondence;
  RansacOptions ransac;
};

}  // namespace isthmus::matching
