#include "floam/match/scan_to_scan.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/geometry/se3.h"
#include "floam/match/limits.h"
#include "floam/match/match_information.h"
#include "floam/match/match_sums.h"

namespace isthmus::floam {
namespace {

template <typename T>
T Squared(T v) {
  return v * v;
}

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
  edge_points_ = features.edges;
  surface_points_ = features.map_surfaces;
  poles_ = features.poles;
  is_indexed_ = false;
}

void ScanToScan::Index() {
  if (is_indexed_) return;
  edges_.Build(edge_points_);
  surfaces_.Build(surface_points_);
  is_indexed_ = true;
}

void ScanToScan::FindPlanes(const Features& features, const ScanMotion& motion, double elapsed_s,
                            float noise2) {
  surface_rows_.clear();
  const auto elapsed = static_cast<float>(elapsed_s);
  for (const TimedPoint& point : features.surfaces) {
    features.work.Add(Work::Kind::kScanToScan, 1 + surfaces_.TakeSteps());
    if (features.work.spent()) return;
    const RingIndex::Query query(motion.ToReference(point.position, elapsed));
    const auto nearest = surfaces_.Nearest(query, options_.reach_m);
    if (nearest.index == RingIndex::kNone) continue;
    const TimedPoint& a = surfaces_.At(nearest.index);
    const auto [left, right] = surfaces_.Along(nearest.index, options_.base_m);
    const auto across = OnNeighbouringRing(surfaces_, query, a.ring, options_);
    if (left == right || across.index == RingIndex::kNone) continue;
    const TimedPoint &b = surfaces_.At(left), &d = surfaces_.At(right);
    const TimedPoint& c = surfaces_.At(across.index);
    if (!AtOneTime(b, d, elapsed_s) || !AtOneTime(a, c, elapsed_s)) continue;
    const Eigen::Vector3f ab = d.position - b.position, ac = c.position - a.position;
    const Eigen::Vector3f cross = ab.cross(ac);
    const float length2 = cross.squaredNorm(), ab2 = ab.squaredNorm();
    if (!(length2 > kLeastPlaneSine * kLeastPlaneSine * ab2 * ac.squaredNorm())) continue;
    const Eigen::Vector3f normal = cross / std::sqrt(length2);
    // There is no plane, or a false one, where a ring leaves a wall for the floor.
    const auto [c_left, c_right] = surfaces_.Along(across.index, options_.base_m);
    const auto is_off = [&](const TimedPoint& p) {
      return std::abs(normal.dot(p.position - a.position)) > options_.flat_m;
    };
    if (is_off(b) || is_off(d) || is_off(surfaces_.At(c_left)) || is_off(surfaces_.At(c_right))) {
      continue;
    }
    const float height2 = length2 / ab2;  // Height of c over the line along a's ring, squared.
    surface_rows_.push_back({point.position, elapsed + point.time - a.time, point.weight, normal,
                             normal.dot(a.position), a.position,
                             noise2 * std::max(2 / ab2, 1.5F / height2)});
  }
  features.work.Add(Work::Kind::kScanToScan, surfaces_.TakeSteps());
}

void ScanToScan::FindLines(const Features& features, const ScanMotion& motion, double elapsed_s,
                           float noise2) {
  edge_rows_.clear();
  const auto elapsed = static_cast<float>(elapsed_s);
  for (const TimedPoint& point : features.edges) {
    features.work.Add(Work::Kind::kScanToScan, 1 + edges_.TakeSteps());
    if (features.work.spent()) return;
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
                            normal.dot(a.position), a.position, 2 * noise2 / along.squaredNorm()});
    }
  }
  features.work.Add(Work::Kind::kScanToScan, edges_.TakeSteps());
}

// The nearest pole, at whatever height it was hit: along the ray and across it on the level.
void ScanToScan::FindPoles(const std::vector<TimedPoint>& poles, const ScanMotion& motion,
                           double elapsed_s) {
  pole_rows_.clear();
  const auto elapsed = static_cast<float>(elapsed_s);
  for (const TimedPoint& point : poles) {
    const Eigen::Vector3f q = motion.ToReference(point.position, elapsed);
    const Eigen::Vector3f ray = q.normalized();
    const Eigen::Vector3f across = Eigen::Vector3f::UnitZ().cross(ray).normalized();
    const TimedPoint* nearest = nullptr;
    float best2 = options_.pole_reach_m * options_.pole_reach_m;
    for (const TimedPoint& pole : poles_) {
      const Eigen::Vector3f offset = q - pole.position;
      const float distance2 = Squared(ray.dot(offset)) + Squared(across.dot(offset));
      if (distance2 >= best2 || offset.squaredNorm() > kPoleLengthM * kPoleLengthM) continue;
      best2 = distance2;
      nearest = &pole;
    }
    if (nearest == nullptr || !AtOneTime(*nearest, point, elapsed_s)) continue;
    for (const Eigen::Vector3f& normal : {ray, across}) {
      pole_rows_.push_back({point.position, elapsed + point.time - nearest->time, point.weight,
                            normal, normal.dot(nearest->position), nearest->position, 0});
    }
  }
}

// With T = Exp(xi) the motion in `elapsed_s` and s the share of it that lies between two points,
// the residual is n . q - offset with q = Exp(s xi) p. A small motion T -> Exp(d) T moves q by
// Exp(s d), to first order in the motion (the left Jacobians of xi and s xi are taken as identity).
bool ScanToScan::Step(const ScanMotion& motion, double elapsed_s, const PosePrior& prior,
                      Pose* moved, ScanToScanResult* result) {
  rows_.clear();
  result->score = result->evidence = 0;
  const auto place = [&](const Row& row) { return motion.ToReference(row.position, row.since); };
  const auto distance = [](const Row& row, const Eigen::Vector3f& q) {
    return static_cast<double>(row.normal.dot(q) - row.offset);
  };
  const auto add = [&](const Row& row, const Eigen::Vector3f& q, double r, double scale_by,
                       double sigma_m) {
    // As much as if it had moved all the way; not nothing, or nothing could be divided by it.
    const double share = std::max(row.since / elapsed_s, 1e-3);
    const Vector6d jacobian = PoseJacobian(q.cast<double>(), row.normal.cast<double>());
    const double weight = row.weight * HuberWeight(scale_by, options_.kernel_m) / Squared(sigma_m);
    rows_.push_back({jacobian, Squared(share) * weight, r / share, 0, q.cast<double>(),
                     (q - row.on_plane).cast<double>(), row.tilt_variance});
  };
  const auto score = [&](double r, double worth) {
    const double weight = Squared(1 / (1 + Squared(r / options_.kernel_m)));
    result->score += weight;
    result->evidence += worth * weight;
  };
  for (const Row& row : surface_rows_) {
    const Eigen::Vector3f q = place(row);
    const double r = distance(row, q);
    add(row, q, r, std::abs(r), options_.row_sigma_m);
    score(r, std::abs(row.normal.z()) > kGroundNormalZ ? 0 : 1);
  }
  const auto add_pairs = [&](const std::vector<Row>& rows, double sigma_m, double worth) {
    for (size_t k = 0; k + 1 < rows.size(); k += 2) {
      const Row &u = rows[k], &v = rows[k + 1];
      const Eigen::Vector3f q = place(u);
      const double ru = distance(u, q), rv = distance(v, q);
      add(u, q, ru, std::hypot(ru, rv), sigma_m);
      add(v, q, rv, std::hypot(ru, rv), sigma_m);
      score(std::hypot(ru, rv), worth);
    }
  };
  add_pairs(edge_rows_, options_.row_sigma_m, 1);
  add_pairs(pole_rows_, options_.pole_sigma_m, kPoleWorth);
  if (static_cast<int>(rows_.size()) < kMinScanRows) return false;
  MatchSums sums = SumOf(rows_, false);
  sums.information.bottomRightCorner<6, 6>().setIdentity();
  const Vector6d away = Log(*moved * prior.T_odom_sensor.Inverse());
  const JointEstimate estimate = Solve(sums, rows_, prior.covariance, away);
  const Vector6d step = estimate.step.head<6>();
  if (!step.allFinite()) return false;
  *moved = Exp(step) * *moved;
  result->covariance = estimate.covariance.topLeftCorner<6, 6>();
  result->information = estimate.match_information;
  return true;
}

ScanToScanResult ScanToScan::Match(const Features& features, const Vector6d& guess,
                                   double elapsed_s, const Matrix6d& prior) {
  return Minimise(features, guess, elapsed_s, prior, options_.point_noise_m);
}

ScanToScanResult ScanToScan::Minimise(const Features& features, const Vector6d& guess,
                                      double elapsed_s, const Matrix6d& prior,
                                      double point_noise_m) {
  Index();
  const auto noise2 = static_cast<float>(Squared(point_noise_m));
  ScanToScanResult result;
  result.twist = guess;
  result.features =
      static_cast<int>(features.surfaces.size() + features.edges.size() + features.poles.size());
  Pose moved = Exp(elapsed_s * guess);
  // Steps are taken on the other side.
  const Matrix6d to_left = Adjoint(moved);
  const PosePrior guessed{moved, to_left * prior * to_left.transpose()};
  for (int round = 0; round < options_.rounds; ++round) {
    const ScanMotion found_with = MotionOf(result.twist, elapsed_s);
    FindPlanes(features, found_with, elapsed_s, noise2);
    FindLines(features, found_with, elapsed_s, noise2);
    FindPoles(features.poles, found_with, elapsed_s);
    if (features.work.spent()) return result;
    result.used =
        static_cast<int>(surface_rows_.size() + edge_rows_.size() / 2 + pole_rows_.size() / 2);
    for (int iteration = 0; iteration < options_.iterations; ++iteration) {
      const ScanMotion motion = MotionOf(result.twist, elapsed_s);
      if (!Step(motion, elapsed_s, guessed, &moved, &result)) return result;
      result.twist = Log(moved) / elapsed_s;
    }
  }
  const Matrix6d to_right = Adjoint(moved.Inverse()), back = Adjoint(moved);
  result.covariance = (to_right * result.covariance * to_right.transpose()).eval();
  result.information = (back.transpose() * result.information * back).eval();
  return result;
}

ScanToScanResult ScanToScan::Match(const Features& features, const Vector6d& guess,
                                   double elapsed_s) {
  return Minimise(features, guess, elapsed_s,
                  Isotropic(options_.guess_sigma_m, options_.guess_sigma_rad), 0);
}

double ScanToScan::Evidence(const Features& features, const Vector6d& twist, double elapsed_s) {
  Index();
  const ScanMotion motion = MotionOf(twist, elapsed_s);
  FindPlanes(features, motion, elapsed_s, 0);
  FindLines(features, motion, elapsed_s, 0);
  FindPoles(features.poles, motion, elapsed_s);
  ScanToScanResult result;
  Pose moved = Exp(elapsed_s * twist);
  Step(motion, elapsed_s, {moved, Matrix6d::Identity()}, &moved, &result);
  return result.evidence;
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
