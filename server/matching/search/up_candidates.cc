#include "server/matching/search/up_candidates.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "server/matching/search/gravity.h"
#include "server/matching/search/limits.h"

namespace isthmus::matching {
namespace {

std::vector<SurfacePoint> Thin(const std::vector<SurfacePoint>& surface) {
  if (surface.size() <= kMaxLevelSurfaces) return surface;
  std::vector<SurfacePoint> thinned;
  thinned.reserve(kMaxLevelSurfaces);
  for (size_t i = 0; i < kMaxLevelSurfaces; ++i) {
    thinned.push_back(surface[i * surface.size() / kMaxLevelSurfaces]);
  }
  return thinned;
}

// Mean normals and their number, the two directions of an axis taken as one.
std::vector<Eigen::Vector4f> GatherNormals(const std::vector<SurfacePoint>& surface) {
  std::map<std::pair<int, int>, Eigen::Vector4f> cells;
  for (const SurfacePoint& point : surface) {
    int axis = 0;
    point.normal.cwiseAbs().maxCoeff(&axis);
    const Eigen::Vector3f n =
        point.normal[axis] < 0 ? Eigen::Vector3f(-point.normal) : point.normal;
    const auto cell = [&](int k) {
      return static_cast<int>(std::floor(n[(axis + k) % 3] / n[axis] * kNormalCellsPerUnit));
    };
    auto [it, fresh] = cells.try_emplace({3 * cell(1) + axis, cell(2)}, Eigen::Vector4f::Zero());
    it->second += Eigen::Vector4f(n.x(), n.y(), n.z(), 1);
  }
  std::vector<Eigen::Vector4f> gathered;
  gathered.reserve(cells.size());
  for (const auto& [key, sum] : cells) {
    const Eigen::Vector3f mean = sum.head<3>().normalized();
    gathered.emplace_back(mean.x(), mean.y(), mean.z(), sum.w());
  }
  return gathered;
}

// Evenly over the half sphere z >= 0: a spiral that turns by the golden angle.
Eigen::Vector3f HalfSpherePoint(int i) {
  const double z = (i + 0.5) / kUpHypotheses, r = std::sqrt(1 - z * z);
  const double azimuth = i * std::numbers::pi * (3 - std::sqrt(5.0));
  return Eigen::Vector3d(r * std::cos(azimuth), r * std::sin(azimuth), z).cast<float>();
}

// Axes along and across which most surfaces face.
std::vector<Eigen::Vector3d> FindAxes(const std::vector<SurfacePoint>& surface) {
  const std::vector<Eigen::Vector4f> normals = GatherNormals(surface);
  std::vector<std::pair<float, int>> ranked;
  for (int i = 0; i < kUpHypotheses; ++i) {
    const Eigen::Vector3f axis = HalfSpherePoint(i);
    float mass = 0;
    for (const Eigen::Vector4f& normal : normals) {
      const float along = std::abs(axis.dot(normal.head<3>()));
      if (along > kAlongUpCosine || along < kAcrossUpSine) mass += normal.w();
    }
    ranked.emplace_back(-mass, i);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<Eigen::Vector3d> axes;
  for (const auto& [mass, i] : ranked) {
    const Eigen::Vector3d axis = HalfSpherePoint(i).cast<double>();
    const bool taken = std::any_of(axes.begin(), axes.end(), [&](const Eigen::Vector3d& other) {
      return std::abs(axis.dot(other)) > std::cos(kUpAxisSpacingRad);
    });
    if (!taken) axes.push_back(axis);
    if (axes.size() == kMaxUpAxes) break;
  }
  return axes;
}

Eigen::Vector3d Refine(const std::vector<SurfacePoint>& surface, const Eigen::Vector3d& axis) {
  const auto R = Eigen::Quaterniond::FromTwoVectors(axis, Eigen::Vector3d::UnitZ());
  const Eigen::Matrix3f R_float = R.toRotationMatrix().cast<float>();
  std::vector<SurfacePoint> turned = surface;
  for (SurfacePoint& point : turned) point.normal = R_float * point.normal;
  return (EstimateLevel(turned, kUpRefinementRad) * R).inverse() * Eigen::Vector3d::UnitZ();
}

// Surfaces that face one way along an axis, by where they are along it.
struct Layers {
  std::vector<float> offsets;

  // Number of surfaces times the share of them that lies in one plane.
  double Evidence() {
    if (offsets.empty()) return 0;
    std::sort(offsets.begin(), offsets.end());
    size_t most = 0, first = 0;
    for (size_t i = 0; i < offsets.size(); ++i) {
      while (offsets[i] - offsets[first] > kPlaneThicknessM) ++first;
      most = std::max(most, i - first + 1);
    }
    return static_cast<double>(most);
  }
  // Only after Evidence().
  float Median() const { return offsets[offsets.size() / 2]; }
};

float MedianAlong(const std::vector<Eigen::Vector3f>& positions, const Eigen::Vector3f& axis) {
  std::vector<float> along;
  along.reserve(positions.size());
  for (const Eigen::Vector3f& position : positions) along.push_back(axis.dot(position));
  std::nth_element(along.begin(), along.begin() + along.size() / 2, along.end());
  return along[along.size() / 2];
}

// Sum over the steps of d d^T times their length, d being the direction.
Eigen::Matrix3d Directions(const std::vector<Eigen::Vector3f>& path) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (size_t i = 1; i < path.size(); ++i) {
    const Eigen::Vector3d step = (path[i] - path[i - 1]).cast<double>();
    if (step.norm() > 0) sum.noalias() += step * step.transpose() / step.norm();
  }
  return sum;
}

// Scores of hypotheses on one map.
class UpScorer {
 public:
  UpScorer(const std::vector<SurfacePoint>& surface, const std::vector<Eigen::Vector3f>& sensors)
      : surface_(surface), sensors_(sensors) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const SurfacePoint& point : surface) mean += point.position.cast<double>();
    mean /= static_cast<double>(surface.size());
    for (const SurfacePoint& point : surface) {
      const Eigen::Vector3d d = point.position.cast<double>() - mean;
      spread_.noalias() += d * d.transpose() / static_cast<double>(surface.size());
    }
    path_ = Directions(sensors);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread_);
    largest_ = std::max(1e-6, solver.eigenvalues()[2]);
  }

  // For both ends of the axis.
  void Add(const Eigen::Vector3d& axis, std::vector<UpCandidate>* candidates) const {
    const Eigen::Vector3f up = axis.cast<float>();
    Layers floors, ceilings;
    size_t explained = 0;
    for (const SurfacePoint& point : surface_) {
      const float along = point.normal.dot(up);
      if (along > kAlongUpCosine) floors.offsets.push_back(up.dot(point.position));
      if (along < -kAlongUpCosine) ceilings.offsets.push_back(up.dot(point.position));
      explained += std::abs(along) > kAlongUpCosine || std::abs(along) < kAcrossUpSine;
    }
    const double flatness2 = axis.dot(spread_ * axis) / largest_;
    const double climb2 = axis.dot(path_ * axis) / (path_.trace() + kLeastPathM);
    const double vertical = static_cast<double>(explained) / static_cast<double>(surface_.size()) /
                            (1 + flatness2 / (kHalfFlatness * kHalfFlatness)) /
                            (1 + std::min(1.0, climb2 / (kHalfClimb * kHalfClimb)));
    const double up_share = UpShare(up, &floors, &ceilings);
    const double up_score = vertical * up_share, down_score = vertical - up_score;
    const auto add = [&](const Eigen::Vector3d& end, double score, double opposite) {
      candidates->push_back(
          {Eigen::Quaterniond::FromTwoVectors(end, Eigen::Vector3d::UnitZ()), score, opposite});
    };
    add(axis, up_score, down_score);
    add(-axis, down_score, up_score);
  }

 private:
  // The probability that up is up and not down.
  double UpShare(const Eigen::Vector3f& up, Layers* floors, Layers* ceilings) const {
    double below = floors->Evidence(), above = ceilings->Evidence();
    if (below + above == 0) return 0.5;
    if (!sensors_.empty() && !floors->offsets.empty() && !ceilings->offsets.empty()) {
      const float floor = floors->Median(), ceiling = ceilings->Median();
      const double height = (MedianAlong(sensors_, up) - floor) / (ceiling - floor);
      const double clamped = std::clamp(height, kMinSensorHeight, 1 - kMinSensorHeight);
      if (ceiling > floor) {
        below *= 1 - clamped;
        above *= clamped;
      }
    }
    return below / (below + above);
  }

  const std::vector<SurfacePoint>& surface_;
  const std::vector<Eigen::Vector3f>& sensors_;
  Eigen::Matrix3d spread_ = Eigen::Matrix3d::Zero();  // The surface's, square metres.
  Eigen::Matrix3d path_;                              // The sensors', metres.
  double largest_ = 1;
};

Eigen::Vector3d Up(const UpCandidate& candidate) {
  return candidate.R_level_odom.inverse() * Eigen::Vector3d::UnitZ();
}

// Best first, and none near a better one.
std::vector<UpCandidate> Distinct(std::vector<UpCandidate> candidates) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const UpCandidate& a, const UpCandidate& b) { return a.score > b.score; });
  std::vector<UpCandidate> distinct;
  for (const UpCandidate& candidate : candidates) {
    const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const UpCandidate& other) {
      return Up(candidate).dot(Up(other)) > std::cos(kDistinctUpRad);
    });
    if (!known) distinct.push_back(candidate);
  }
  return distinct;
}

}  // namespace

std::vector<UpCandidate> FindUpCandidates(const std::vector<SurfacePoint>& surface,
                                          const std::vector<Eigen::Vector3f>& sensors) {
  if (surface.size() < kMinLevelSurfaces) return {UpCandidate()};
  const std::vector<SurfacePoint> thinned = Thin(surface);
  std::vector<Eigen::Vector3d> axes = FindAxes(thinned);
  axes.push_back(Eigen::Vector3d::UnitZ());
  const UpScorer judge(thinned, sensors);
  std::vector<UpCandidate> candidates;
  for (const Eigen::Vector3d& axis : axes) judge.Add(Refine(thinned, axis), &candidates);
  return Distinct(std::move(candidates));
}

UpCandidate LikeliestUp(const std::vector<UpCandidate>& candidates) {
  if (candidates.empty()) return {};
  const auto believed = [](const UpCandidate& candidate) {
    const bool leans = std::abs(Up(candidate).z()) > std::cos(kMaxLeanRad);
    return candidate.axis() / (leans ? kBelieveUprightShare : 1);
  };
  const UpCandidate best = *std::max_element(
      candidates.begin(), candidates.end(),
      [&](const UpCandidate& x, const UpCandidate& y) { return believed(x) < believed(y); });
  const bool hangs = Up(best).z()<-kUprightCosine, stands = Up(best).z()> kUprightCosine;
  const double odds = hangs ? 1 / kUprightOdds : stands ? kUprightOdds : 1;
  if (odds * best.score >= best.opposite) return best;
  return {Eigen::Quaterniond::FromTwoVectors(-Up(best), Eigen::Vector3d::UnitZ()), best.opposite,
          best.score};
}

}  // namespace isthmus::matching
