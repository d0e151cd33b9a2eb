#include "server/matching/registration/refine.h"

#include <algorithm>
#include <utility>

#include "server/matching/registration/alignment_quality.h"
#include "server/matching/registration/gicp.h"
#include "server/matching/registration/limits.h"
#include "server/matching/registration/refinable_map.h"
#include "server/matching/registration/surface_sample.h"

namespace isthmus::matching {
namespace {

void RunGicp(const RefinableMap::Data& a, const RefinableMap::Data& b, const RefineOptions& options,
             Pose* T_a_b) {
  double gate = std::max(options.coarse_distance_m, LeastGate(a.voxel_m));
  PairSet found;
  for (int i = 0; i < options.max_iterations; ++i) {
    FindGicpPairs(a.points, a.tree, b.points, b.coarse_sample, *T_a_b, gate, &found);
    Vector6d twist;
    if (!StepPose(found.pairs, kDamping, T_a_b, &twist)) return;
    const double shrunk = NextGate(gate, found.median_normal_distance_m, a.voxel_m);
    if (IsSmallStep(twist, kCoarseStepM) && shrunk > 0.99 * gate) return;
    gate = shrunk;
  }
}

// True when the steps became small.
bool RunVgicp(const GaussianVoxelMap& a, const RefinableMap::Data& b, const RefineOptions& options,
              Pose* T_a_b) {
  std::vector<Correspondence> pairs;
  for (int i = 0; i < options.max_iterations; ++i) {
    FindVgicpPairs(a, b.points, b.fine_sample, *T_a_b, &pairs);
    Vector6d twist;
    if (!StepPose(pairs, kDamping, T_a_b, &twist)) return false;
    if (IsSmallStep(twist, kFineStepM)) return true;
  }
  return false;
}

}  // namespace

RefinableMap::RefinableMap(std::vector<SurfacePoint> surface, const RefineOptions& options)
    : data_(std::make_unique<Data>()) {
  data_->voxel_m = options.voxel_m;
  data_->points = std::move(surface);
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(data_->points.size());
  for (const SurfacePoint& point : data_->points) positions.push_back(point.position);
  data_->tree = KdTree(positions);
  // A Gaussian wants several points.
  const double gaussian_voxel_m = std::max(options.vgicp_voxel_m, 3.0 * data_->voxel_m);
  data_->voxels = GaussianVoxelMap(data_->points, gaussian_voxel_m);
  data_->fine_voxels = GaussianVoxelMap(data_->points, 0.5 * gaussian_voxel_m);
  data_->coarse_sample = SampleBalanced(data_->points, 4.0 * data_->voxel_m, kMaxCoarsePoints);
  data_->fine_sample = SampleBalanced(data_->points, data_->voxel_m, kMaxFinePoints);
}

RefinableMap::~RefinableMap() = default;
RefinableMap::RefinableMap(RefinableMap&&) noexcept = default;

double CoarseOverlap(const RefinableMap& a, const RefinableMap& b, const Pose& T_a_b,
                     double reach_m) {
  const std::vector<SurfacePoint>&fixed = a.data().points, &moving = b.data().points;
  const std::vector<int>& sample = b.data().coarse_sample;
  const Eigen::Matrix3f R = T_a_b.RotationMatrix().cast<float>();
  const Eigen::Vector3f t = T_a_b.translation().cast<float>();
  const size_t stride = sample.size() / kMaxFirstLookPoints + 1;
  size_t asked = 0, met = 0;
  for (size_t k = 0; k < sample.size(); k += stride, ++asked) {
    const SurfacePoint& point = moving[sample[k]];
    const Eigen::Vector3f n = R * point.normal;
    const auto near =
        a.data().tree.NearestIf(R * point.position + t, static_cast<float>(reach_m),
                                [&](int j) { return fixed[j].normal.dot(n) > kMinNormalCosine; });
    met += near.index >= 0;
  }
  return asked > 0 ? static_cast<double>(met) / static_cast<double>(asked) : 0;
}

Pose AlignCoarsely(const RefinableMap& a, const RefinableMap& b, const Pose& guess_T_a_b,
                   const RefineOptions& options) {
  Pose T_a_b = guess_T_a_b;
  if (T_a_b.IsFinite()) RunGicp(a.data(), b.data(), options, &T_a_b);
  return T_a_b;
}

Refinement AlignFinely(const RefinableMap& a, const RefinableMap& b, const Pose& coarse_T_a_b,
                       const RefineOptions& options) {
  Refinement result;
  if (!coarse_T_a_b.IsFinite()) return result;
  result.T_a_b = coarse_T_a_b;
  RunVgicp(a.data().voxels, b.data(), options, &result.T_a_b);
  result.converged = RunVgicp(a.data().fine_voxels, b.data(), options, &result.T_a_b);
  MeasureAlignment(a.data(), b.data(), options.overlap_distance_m, &result);
  return result;
}

Refinement RefineAlignment(const RefinableMap& a, const RefinableMap& b, const Pose& guess_T_a_b,
                           const RefineOptions& options) {
  return AlignFinely(a, b, AlignCoarsely(a, b, guess_T_a_b, options), options);
}

}  // namespace isthmus::matching
