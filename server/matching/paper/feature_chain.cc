#include "server/matching/paper/feature_chain.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "core/stopwatch.h"
#include "server/matching/paper/correspondence.h"
#include "server/matching/paper/harris.h"
#include "server/matching/paper/limits.h"
#include "server/matching/paper/normals.h"
#include "server/matching/paper/outlier_removal.h"
#include "server/matching/paper/ransac.h"
#include "server/matching/paper/rigid_fit.h"
#include "server/matching/registration/voxel_filter.h"

namespace isthmus::matching {
namespace {

std::vector<PointPair> Choose(const std::vector<PointPair>& pairs, const std::vector<int>& chosen) {
  std::vector<PointPair> result;
  for (int i : chosen) result.push_back(pairs[i]);
  return result;
}

// The least-squares fit to the consensus, whose inliers follow the fit.
Candidate FitConsensus(const std::vector<PointPair>& pairs, const Consensus& consensus,
                       const RansacOptions& options) {
  Candidate candidate{consensus.T_a_b, static_cast<double>(consensus.inliers.size()),
                      GuessSource::kPaper};
  std::vector<int> inliers = consensus.inliers;
  for (int round = 0; round < kFitRounds; ++round) {
    const Pose fitted = FitRigid(Choose(pairs, inliers));
    inliers = FindInliers(pairs, fitted, options.inlier_distance_m);
    const double kept = static_cast<double>(inliers.size());
    if (kept < kMinKeptShare * static_cast<double>(consensus.inliers.size())) break;
    candidate.T_a_b = fitted;
    candidate.score = kept;
  }
  return candidate;
}

// The best first, without those that the fit has taken to a better one or below a consensus.
std::vector<Candidate> KeepDistinct(std::vector<Candidate> fitted, const Eigen::Vector3d& center_b,
                                    const RansacOptions& options) {
  std::stable_sort(fitted.begin(), fitted.end(),
                   [](const Candidate& x, const Candidate& y) { return x.score > y.score; });
  std::vector<Candidate> kept;
  for (const Candidate& candidate : fitted) {
    if (static_cast<int>(kept.size()) >= options.candidates) break;
    if (candidate.score < options.min_inliers) break;
    const bool distinct = std::all_of(kept.begin(), kept.end(), [&](const Candidate& other) {
      return AreDistinct(candidate.T_a_b, other.T_a_b, center_b, options);
    });
    if (distinct) kept.push_back(candidate);
  }
  return kept;
}

// Adds the times of `from` to those of equal stages in `to`.
void AddTimes(const std::vector<StageTime>& from, std::vector<StageTime>* to) {
  for (const StageTime& time : from) {
    const auto same = std::find_if(
        to->begin(), to->end(), [&](const StageTime& other) { return other.stage == time.stage; });
    if (same == to->end()) {
      to->push_back(time);
    } else {
      same->ms += time.ms;
    }
  }
}

}  // namespace

absl::StatusOr<FeatureSet> ComputeFeatures(const SessionMap& map,
                                           const FeatureChainOptions& options,
                                           std::vector<StageTime>* stages) {
  try {
    Stopwatch stopwatch;
    const auto lap = [&](const char* stage) { stages->push_back({stage, stopwatch.Lap()}); };
    const auto thinned = FilterVoxels(map, options.voxel_filter.voxel_m);
    lap("voxel_filter");
    const auto clean = RemoveOutliers(thinned, options.outlier_removal);
    lap("outlier_removal");
    const OrientedPoints points = EstimateNormals(clean, options.normals);
    lap("normals");
    const std::vector<int> keypoints = DetectHarrisKeypoints(points, options.harris);
    lap("harris");
    FeatureSet features;
    features.descriptors = DescribeFpfh(points, keypoints, options.fpfh);
    for (int index : keypoints) features.keypoints.push_back(points.positions[index]);
    lap("fpfh");
    return features;
  } catch (const std::exception& error) {
    return absl::InternalError(absl::StrCat("features of ", map.session.value(),
                                            " could not be computed: ", error.what()));
  }
}

std::vector<Candidate> MatchFeatures(const FeatureSet& a, const FeatureSet& b,
                                     const FeatureChainOptions& options,
                                     std::vector<StageTime>* stages) {
  Stopwatch stopwatch;
  std::vector<PointPair> pairs;
  for (const FeatureMatch& match :
       MatchReciprocally(a.descriptors, b.descriptors, options.correspondence)) {
    pairs.push_back({a.keypoints[match.a], b.keypoints[match.b]});
  }
  stages->push_back({"correspondence", stopwatch.Lap()});
  const std::vector<Consensus> found = FindConsensus(pairs, options.ransac);
  stages->push_back({"ransac", stopwatch.Lap()});
  std::vector<Candidate> fitted;
  for (const Consensus& consensus : found) {
    fitted.push_back(FitConsensus(pairs, consensus, options.ransac));
  }
  const auto candidates = KeepDistinct(std::move(fitted), CenterOfB(pairs), options.ransac);
  stages->push_back({"svd", stopwatch.Lap()});
  return candidates;
}

std::vector<Candidate> SearchByFeatures(const SessionMap& a, const SessionMap& b,
                                        const FeatureChainOptions& options,
                                        std::vector<StageTime>* stages) {
  std::vector<StageTime> times;
  const auto features_a = ComputeFeatures(a, options, &times);
  const auto features_b = ComputeFeatures(b, options, &times);
  AddTimes(times, stages);
  if (!features_a.ok() || !features_b.ok()) return {};
  return MatchFeatures(*features_a, *features_b, options, stages);
}

}  // namespace isthmus::matching
