#include "floam/scan_to_scan.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "floam/normal_equations.h"

namespace isthmus::floam {
namespace {

double Squared(double v) { return v * v; }

constexpr int kLeastRows = 10;
// Three points of which the third is nearer than this to the line through the others (sine of the
// angle) are no plane.
constexpr float kLeastSine = 0.05F;

// Exp(t twist) for t up to the longest time between points of the two scans.
ScanMotion MotionOf(const Vector6d& twist, double elapsed_s) {
  return ScanMotion(twist, 0, 0, 2 * elapsed_s);
}

// The nearest on the rings next to `ring`, that ring apart.
RingIndex::Neighbour OnNeighbouringRing(const RingIndex& index, const RingIndex::Query& query,
                                        int ring, const ScanToScanOptions& options) {
  RingIndex::Neighbour best;
  best.distance2 = options.reach_m * options.reach_m;
  for (int away = 1; away <= options.ring_reach; ++away) {
    index.NearestOnRing(query, ring - away, RingIndex::kNone, &best);
    index.NearestOnRing(query, ring + away, RingIndex::kNone, &best);
  }
  return best;
}

// False across the seam, where one neighbour was measured at the beginning and one at the end.
bool AtOneTime(const TimedPoint& a, const TimedPoint& b, double elapsed_s) {
  return std::abs(a.time - b.time) < 0.5 * elapsed_s;
}

double HuberWeight(double distance, double scale) {
  return distance <= scale ? 1 : scale / distance;
}

}  // namespace

ScanToScan::ScanToScan(const ScanToScanOptions& options) : options_(options) {}

void ScanToScan::SetPrevious(const Features& features) {
  edges_.Build(features.edges);
  surfaces_.Build(features.map_surfaces);
}

void ScanToScan::FindPlanes(const std::vector<TimedPoint>& surfaces, const ScanMotion& motion,
                            double elapsed_s) {
  surface_rows_.clear();
  const auto elapsed = static_cast<float>(elapsed_s);
  for (const TimedPoint& point : surfaces) {
    const RingIndex::Query query(motion.ToReference(point.position, elapsed));
    const auto nearest = surfaces_.Nearest(query, options_.reach_m);
    if (nearest.index == RingIndex::kNone) continue;
    const TimedPoint& a = surfaces_.At(nearest.index);
    RingIndex::Neighbour beside;
    beside.distance2 = options_.reach_m * options_.reach_m;
    surfaces_.NearestOnRing(query, a.ring, nearest.index, &beside);
    const auto across = OnNeighbouringRing(surfaces_, query, a.ring, options_);
    if (beside.index == RingIndex::kNone || across.index == RingIndex::kNone) continue;
    const TimedPoint &b = surfaces_.At(beside.index), &c = surfaces_.At(across.index);
    if (!AtOneTime(a, b, elapsed_s) || !AtOneTime(a, c, elapsed_s)) continue;
    const Eigen::Vector3f ab = b.position - a.position, ac = c.position - a.position;
    const Eigen::Vector3f cross = ab.cross(ac);
    const float length2 = cross.squaredNorm();
    if (!(length2 > kLeastSine * kLeastSine * ab.squaredNorm() * ac.squaredNorm())) continue;
    const Eigen::Vector3f normal = cross / std::sqrt(length2);
    surface_rows_.push_back({point.position, elapsed + point.time - a.time, point.weight, normal,
                             normal.dot(a.position)});
  }
}

void ScanToScan::FindLines(const std::vector<TimedPoint>& edges, const ScanMotion& motion,
                           double elapsed_s) {
  edge_rows_.clear();
  const auto elapsed = static_cast<float>(elapsed_s);
  for (const TimedPoint& point : edges) {
    const RingIndex::Query query(motion.ToReference(point.position, elapsed));
    const auto nearest = edges_.Nearest(query, options_.reach_m);
    if (nearest.index == RingIndex::kNone) continue;
    const TimedPoint& a = edges_.At(nearest.index);
    const auto across = OnNeighbouringRing(edges_, query, a.ring, options_);
    if (across.index == RingIndex::kNone) continue;
    const TimedPoint& b = edges_.At(across.index);
    const Eigen::Vector3f along = b.position - a.position;
    if (!AtOneTime(a, b, elapsed_s) || !(along.squaredNorm() > 1e-6F)) continue;
    const Eigen::Vector3f u = along.unitOrthogonal();
    for (const Eigen::Vector3f& normal : {u, Eigen::Vector3f(along.normalized().cross(u))}) {
      edge_rows_.push_back({point.position, elapsed + point.time - a.time, point.weight, normal,
                            normal.dot(a.position)});
    }
  }
}

// With T = Exp(xi) the motion in `elapsed_s` and s the share of it that lies between two points,
// the residual is n . q - offset with q = Exp(s xi) p. A small motion T -> Exp(d) T moves q by
// Exp(s d), to first order in the motion (the left Jacobians of xi and s xi are taken as identity).
bool ScanToScan::Step(const ScanMotion& motion, double elapsed_s, const Pose& guessed,
                      Pose* moved) const {
  NormalEquations equations;
  const auto place = [&](const Row& row) { return motion.ToReference(row.position, row.since); };
  const auto distance = [](const Row& row, const Eigen::Vector3f& q) {
    return static_cast<double>(row.normal.dot(q) - row.offset);
  };
  const auto add = [&](const Row& row, const Eigen::Vector3f& q, double r, double scale_by) {
    const Vector6d jacobian = PoseJacobian(q.cast<double>(), row.normal.cast<double>());
    const double weight = row.weight * HuberWeight(scale_by, options_.kernel_m);
    equations.Add(row.since / elapsed_s * jacobian, 0, weight, r, false);
  };
  for (const Row& row : surface_rows_) {
    const Eigen::Vector3f q = place(row);
    const double r = distance(row, q);
    add(row, q, r, std::abs(r));
  }
  for (size_t k = 0; k + 1 < edge_rows_.size(); k += 2) {
    const Row &u = edge_rows_[k], &v = edge_rows_[k + 1];
    const Eigen::Vector3f q = place(u);
    const double ru = distance(u, q), rv = distance(v, q);
    add(u, q, ru, std::hypot(ru, rv));
    add(v, q, rv, std::hypot(ru, rv));
  }
  const auto rows = static_cast<int>(surface_rows_.size() + edge_rows_.size());
  if (rows < kLeastRows) return false;
  Vector6d weight;
  weight << Eigen::Vector3d::Constant(Squared(options_.row_sigma_m / options_.guess_sigma_m)),
      Eigen::Vector3d::Constant(Squared(options_.row_sigma_m / options_.guess_sigma_rad));
  Matrix6d H = equations.pose();
  H.diagonal() += weight;
  const Vector6d away = weight.cwiseProduct(Log(*moved * guessed.Inverse()));
  const Vector6d step = -H.ldlt().solve(equations.Gradient().head<6>() + away);
  if (!step.allFinite()) return false;
  *moved = Exp(step) * *moved;
  return true;
}

ScanToScanResult ScanToScan::Match(const Features& features, const Vector6d& guess,
                                   double elapsed_s) {
  ScanToScanResult result;
  result.twist = guess;
  result.features = static_cast<int>(features.surfaces.size() + features.edges.size());
  const Pose guessed = Exp(elapsed_s * guess);
  Pose moved = guessed;
  for (int round = 0; round < options_.rounds; ++round) {
    const ScanMotion found_with = MotionOf(result.twist, elapsed_s);
    FindPlanes(features.surfaces, found_with, elapsed_s);
    FindLines(features.edges, found_with, elapsed_s);
    result.used = static_cast<int>(surface_rows_.size() + edge_rows_.size() / 2);
    for (int iteration = 0; iteration < options_.iterations; ++iteration) {
      if (!Step(MotionOf(result.twist, elapsed_s), elapsed_s, guessed, &moved)) return result;
      result.twist = Log(moved) / elapsed_s;
    }
  }
  return result;
}

ScanPose ScanToScan::Guess(const Features& features, const ScanPose& prediction, double elapsed_s) {
  const ScanToScanResult found = Match(features, prediction.twist, elapsed_s);
  const Pose T_predicted_found = Exp(-elapsed_s * prediction.twist) * Exp(elapsed_s * found.twist);
  const bool credible = found.used >= options_.min_used &&
                        T_predicted_found.translation().norm() < options_.max_surprise_m &&
                        RotationAngle(T_predicted_found) < options_.max_surprise_rad;
  if (!credible) return prediction;
  return {prediction.T_odom_sensor * T_predicted_found, found.twist, prediction.reference_s};
}

}  // namespace isthmus::floam
