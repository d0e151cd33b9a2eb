#include "server/matching/paper/ransac.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "server/matching/paper/limits.h"

namespace isthmus::matching {
namespace {

// SplitMix64 (Steele, Lea, Flood, OOPSLA 2014): the same numbers with every standard library.
class SplitMix {
 public:
  explicit SplitMix(uint64_t seed) : state_(seed) {}
  // In [0, bound); bound below 2^32.
  size_t Below(size_t bound) {
    uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    z ^= z >> 31;
    return static_cast<size_t>((z >> 32) * bound >> 32);
  }

 private:
  uint64_t state_;
};

struct Hypothesis {
  Pose T_a_b;
  size_t inliers = 0;
};

bool EdgesAgree(const PointPair& p, const PointPair& q, const RansacOptions& options) {
  const float edge_a = (p.a - q.a).norm(), edge_b = (p.b - q.b).norm();
  return std::min(edge_a, edge_b) >= options.min_edge_m &&
         std::min(edge_a, edge_b) >= options.edge_similarity * std::max(edge_a, edge_b);
}

template <typename Visit>
void VisitInliers(const std::vector<PointPair>& pairs, const Pose& T_a_b, double distance_m,
                  const Visit& visit) {
  const Eigen::Matrix3f R = T_a_b.RotationMatrix().cast<float>();
  const Eigen::Vector3f t = T_a_b.translation().cast<float>();
  const float distance2 = static_cast<float>(distance_m * distance_m);
  const Eigen::Vector3f* last = nullptr;
  for (size_t i = 0; i < pairs.size(); ++i) {
    if ((R * pairs[i].b + t - pairs[i].a).squaredNorm() >= distance2) continue;
    if (last != nullptr && *last == pairs[i].a) continue;  // Counted with another partner.
    last = &pairs[i].a;
    visit(static_cast<int>(i));
  }
}

// The best hypotheses so far that are distinct from each other, largest first, earlier ones before
// later ones among equals.
class DistinctBest {
 public:
  DistinctBest(const Eigen::Vector3d& center_b, const RansacOptions& options)
      : center_b_(center_b), options_(options) {}

  void Offer(const Hypothesis& hypothesis) {
    if (best_.size() == Limit() && hypothesis.inliers <= best_.back().inliers) return;
    const auto place = std::upper_bound(
        best_.begin(), best_.end(), hypothesis,
        [](const Hypothesis& x, const Hypothesis& y) { return x.inliers > y.inliers; });
    const auto same = [&](const Hypothesis& other) {
      return !AreDistinct(hypothesis.T_a_b, other.T_a_b, center_b_, options_);
    };
    if (std::any_of(best_.begin(), place, same)) return;
    const auto at = place - best_.begin();
    best_.erase(std::remove_if(place, best_.end(), same), best_.end());
    best_.insert(best_.begin() + at, hypothesis);
    if (best_.size() > Limit()) best_.pop_back();
  }
  const std::vector<Hypothesis>& best() const { return best_; }

 private:
  size_t Limit() const { return static_cast<size_t>(std::max(options_.hypotheses, 1)); }

  const Eigen::Vector3d center_b_;
  const RansacOptions& options_;
  std::vector<Hypothesis> best_;
};

// Samples after which a consensus of `inliers` would have been hit with near certainty; a sample of
// inliers passes the edge tests in about one of kEdgeLoss cases.
double EnoughIterations(size_t inliers, size_t pairs) {
  const double share = static_cast<double>(inliers) / static_cast<double>(pairs);
  return kMissedLog / std::log1p(-std::min(share * share * share / kEdgeLoss, 0.5));
}

std::vector<Hypothesis> DrawHypotheses(const std::vector<PointPair>& pairs,
                                       const Eigen::Vector3d& center_b,
                                       const RansacOptions& options) {
  const double min_cosine = std::cos(options.max_tilt_rad);
  const size_t min_inliers = static_cast<size_t>(std::max(options.min_inliers, 3));
  SplitMix random(options.seed);
  DistinctBest distinct(center_b, options);
  double enough = options.iterations;
  for (int iteration = 0; iteration < enough; ++iteration) {
    const std::array<PointPair, 3> sample = {pairs[random.Below(pairs.size())],
                                             pairs[random.Below(pairs.size())],
                                             pairs[random.Below(pairs.size())]};
    if (!EdgesAgree(sample[0], sample[1], options) || !EdgesAgree(sample[1], sample[2], options) ||
        !EdgesAgree(sample[2], sample[0], options)) {
      continue;
    }
    Hypothesis hypothesis{FitRigid(sample)};
    if (hypothesis.T_a_b.RotationMatrix()(2, 2) < min_cosine) continue;
    VisitInliers(pairs, hypothesis.T_a_b, options.inlier_distance_m,
                 [&](int) { ++hypothesis.inliers; });
    if (hypothesis.inliers < min_inliers) continue;
    distinct.Offer(hypothesis);
    // A much smaller consensus than the best is not waited for.
    enough = std::min<double>(options.iterations,
                              EnoughIterations(distinct.best().front().inliers / 2, pairs.size()));
  }
  return distinct.best();
}

}  // namespace

std::vector<int> FindInliers(const std::vector<PointPair>& pairs, const Pose& T_a_b,
                             double distance_m) {
  std::vector<int> inliers;
  VisitInliers(pairs, T_a_b, distance_m, [&](int i) { inliers.push_back(i); });
  return inliers;
}

Eigen::Vector3d CenterOfB(const std::vector<PointPair>& pairs) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const PointPair& pair : pairs) sum += pair.b.cast<double>();
  return sum / static_cast<double>(std::max<size_t>(pairs.size(), 1));
}

bool AreDistinct(const Pose& x, const Pose& y, const Eigen::Vector3d& center_b,
                 const RansacOptions& options) {
  return (x * center_b - y * center_b).norm() >= options.distinct_m ||
         RotationAngle(x.Inverse() * y) >= options.distinct_rad;
}

std::vector<Consensus> FindConsensus(const std::vector<PointPair>& pairs,
                                     const RansacOptions& options) {
  if (pairs.size() < 3) return {};
  std::vector<Consensus> found;
  for (const Hypothesis& hypothesis : DrawHypotheses(pairs, CenterOfB(pairs), options)) {
    found.push_back(
        {hypothesis.T_a_b, FindInliers(pairs, hypothesis.T_a_b, options.inlier_distance_m)});
  }
  return found;
}

}  // namespace isthmus::matching
