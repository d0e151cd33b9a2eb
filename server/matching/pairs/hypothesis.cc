#include "server/matching/pairs/hypothesis.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/geometry/near.h"
#include "server/matching/pairs/limits.h"
#include "server/matching/registration/limits.h"
#include "server/pose_graph/limits.h"

namespace isthmus::matching {
namespace {

size_t SurfaceSize(const PreparedMap& map) {
  size_t size = 0;
  for (const auto& submap : map.submaps()) size += submap->surface().size();
  return size;
}

// The smallest eigenvalue of the translation's information about `center` with the rotation free
// (Schur complement), per inlier and in units of one inlier's.
double WeakestObservability(const SurfaceAgreement& agreement, const Eigen::Vector3d& center) {
  if (agreement.on == 0) return 0;
  // A twist [rho; phi] about the origin moves the center by rho' = rho + phi x center.
  Matrix6d J = Matrix6d::Identity();
  J.topRightCorner<3, 3>() = Skew(center);
  const Matrix6d H = J.transpose() * agreement.scatter * J;
  const Eigen::Matrix3d rotation = H.bottomRightCorner<3, 3>();
  const Eigen::Matrix3d cross = H.topRightCorner<3, 3>();
  const Eigen::Matrix3d held =
      H.topLeftCorner<3, 3>() - cross * rotation.ldlt().solve(cross.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(held, Eigen::EigenvaluesOnly);
  const double least = solver.eigenvalues()[0];
  return least > 0 ? least / static_cast<double>(agreement.on) : 0;
}

// The submap whose surface is compared, and the one it is compared with.
struct Sides {
  const PreparedSubmaps &moving, &fixed;
  const std::vector<Pose>&moving_poses, &fixed_poses;
};

Sides SidesOf(const PreparedMap& a, const PreparedMap& b, const Hypothesis& h) {
  const MapPoses& poses = h.joint.poses;
  return h.moving_is_b ? Sides{b.submaps(), a.submaps(), poses.b, poses.a}
                       : Sides{a.submaps(), b.submaps(), poses.a, poses.b};
}

// The kind of maps. Measures that judge only sessions' maps need whole maps: windows do without.
enum class Of { kWindows, kSessions };

// The agreement of every submap of the moving map for which `asked(k)` is true.
template <typename Asked>
void MeasureSurface(const PreparedMap& a, const PreparedMap& b, Of of, const Asked& asked,
                    Hypothesis* h) {
  const auto& [moving, fixed, moving_poses, fixed_poses] = SidesOf(a, b, *h);
  h->agreement.resize(moving.size());
  const Eigen::Vector3d up = a.T_level_odom().rotation().inverse() * Eigen::Vector3d::UnitZ();
  std::optional<DistinctiveSides> sides;
  if (of == Of::kSessions) {
    h->own = a.own_agreement();
    h->own += b.own_agreement();
    sides = {&a.distinctive(), &b.distinctive()};
    if (h->moving_is_b) std::swap(sides->submap, sides->map);
  }
  SurfaceAgreement sum;
  for (size_t k = 0; k < moving.size(); ++k) {
    if (asked(k)) {
      h->agreement[k] =
          MeasureAgreement(*moving[k], moving_poses[k], fixed, fixed_poses, up, kOnSurfaceM, sides);
    }
    sum += h->agreement[k];
  }
  h->inliers = sum.on;
  h->overlap = sum.overlap();
  h->inlier_ratio = sum.ratio();
  h->distinctive = sum.on_distinctive;
  h->upright_ratio = sum.upright_ratio();
  h->residual_m = sum.residual_m();
  h->observability = WeakestObservability(sum, h->shared_center);
}

// Looks for each map's things in the other, for the submaps that are asked.
template <typename AskedA, typename AskedB>
void MeasureThings(const PreparedMap& a, const PreparedMap& b, const AskedA& asked_a,
                   const AskedB& asked_b, Hypothesis* h) {
  const MapPoses& poses = h->joint.poses;
  const Things &in_a = a.things(), &in_b = b.things();
  h->things_a.resize(a.submaps().size());
  h->things_b.resize(b.submaps().size());
  for (size_t k = 0; k < h->things_a.size(); ++k) {
    if (asked_a(k)) h->things_a[k] = in_a.In(in_b, k, poses.a[k], poses.b);
  }
  for (size_t k = 0; k < h->things_b.size(); ++k) {
    if (asked_b(k)) h->things_b[k] = in_b.In(in_a, k, poses.b[k], poses.a);
  }
  h->things = {};
  for (const auto* things : {&h->things_a, &h->things_b}) {
    for (const ThingAgreement& of_submap : *things) h->things += of_submap;
  }
}

bool HasMoved(const std::vector<Pose>& before, const std::vector<Pose>& after) {
  for (size_t k = 0; k < before.size(); ++k) {
    const Pose moved = before[k].Inverse() * after[k];
    if (moved.translation().norm() > kMovedM ||
        RotationAngle(moved) > kMovedM / pose_graph::kLeverM)
      return true;
  }
  return false;
}

// True if the submap meets one of the map from `first_new` on.
bool MeetsNew(const PreparedSubmap& submap, const Pose& T_common_submap, const PreparedMap& map,
              const std::vector<Pose>& T_common_map, size_t first_new) {
  for (size_t i = first_new; i < map.submaps().size(); ++i) {
    if (Meet(*map.submaps()[i], submap, T_common_map[i].Inverse() * T_common_submap)) return true;
  }
  return false;
}

// New submaps follow the last one that was placed.
void PlaceNew(const PreparedSubmaps& submaps, const Pose& T_common_odom, std::vector<Pose>* poses) {
  for (size_t k = poses->size(); k < submaps.size(); ++k) {
    const Pose& T_odom_submap = submaps[k]->submap().T_odom_submap;
    poses->push_back(k == 0 ? T_common_odom * T_odom_submap
                            : (*poses)[k - 1] * submaps[k - 1]->submap().T_odom_submap.Inverse() *
                                  T_odom_submap);
  }
}

// Reduces `items` to those at the positions kept, as far as there are so many.
template <typename T>
void Reduce(const std::vector<size_t>& kept, std::vector<T>* items) {
  std::vector<T> left;
  for (const size_t i : kept) {
    if (i < items->size()) left.push_back((*items)[i]);
  }
  *items = std::move(left);
}

// The position of an item after Reduce, or nothing.
std::optional<uint32_t> PositionAfter(const std::vector<size_t>& kept, uint32_t position) {
  const auto at = std::lower_bound(kept.begin(), kept.end(), position);
  if (at == kept.end() || *at != position) return std::nullopt;
  return static_cast<uint32_t>(at - kept.begin());
}

// Replaces the positions in the maps by those after Reduce; false where either is gone.
bool MovePositions(const std::vector<size_t>& kept_a, const std::vector<size_t>& kept_b,
                   uint32_t* a, uint32_t* b) {
  const auto in_a = PositionAfter(kept_a, *a), in_b = PositionAfter(kept_b, *b);
  if (!in_a || !in_b) return false;
  *a = *in_a;
  *b = *in_b;
  return true;
}

// Reduces `items` to those for which `move` is true, as it leaves them.
template <typename T, typename Move>
void KeepMoved(const Move& move, std::vector<T>* items) {
  std::vector<T> left;
  for (T item : *items) {
    if (move(&item)) left.push_back(std::move(item));
  }
  *items = std::move(left);
}

// The number of kept positions below this one.
size_t CountBelow(const std::vector<size_t>& kept, size_t position) {
  return static_cast<size_t>(std::lower_bound(kept.begin(), kept.end(), position) - kept.begin());
}

void Measure(const PreparedMap& a, const PreparedMap& b, Of of, Hypothesis* h) {
  h->joint = {MapPoses::Rigid(a.session_map(), b.session_map(), h->T_a_b),
              std::move(h->joint.edges), 0, h->T_a_b, std::move(h->joint.ties)};
  h->converged = RefineJointly(a, b, kSubmapGateM, 0, 0, &h->joint);
  if (!h->converged) h->joint.edges.clear();
  h->T_a_b = h->joint.T_a_b;
  h->odometry_residual = h->joint.odometry_residual;
  h->moving_is_b = SurfaceSize(b) <= SurfaceSize(a);
  const auto all = [](size_t) { return true; };
  MeasureSurface(a, b, of, all, h);
  if (of == Of::kSessions && !h->outdoors) MeasureThings(a, b, all, all, h);
  h->free_space = ScoreFreeSpace(a.free_space(), b.free_space(), h->joint.poses,
                                 FreeSpaceOptions::For(h->outdoors));
}

}  // namespace

double Hypothesis::Support() const {
  return max_free_space > 0 ? free_space.Support(max_free_space) : 0;
}

double Hypothesis::Promise() const {
  return std::log1p(static_cast<double>(inliers)) - kPromiseOfFree * free_space.violation();
}

double Hypothesis::Agreement() const { return TightOverlap(overlap, residual_m); }

void RankHypotheses(std::vector<Hypothesis>* hypotheses) {
  std::stable_sort(
      hypotheses->begin(), hypotheses->end(),
      [](const Hypothesis& x, const Hypothesis& y) { return x.Support() > y.Support(); });
}

std::vector<Hypothesis> MostPromising(std::vector<Hypothesis>* found) {
  std::stable_sort(found->begin(), found->end(), [](const Hypothesis& x, const Hypothesis& y) {
    return x.Promise() > y.Promise();
  });
  const auto most = static_cast<std::ptrdiff_t>(std::min(found->size(), kMaxJoint));
  return {found->begin(), found->begin() + most};
}

bool IsSameAlignment(const Pose& T_a_b, const Pose& other_T_a_b, const Eigen::Vector3d& middle_b) {
  return (T_a_b * middle_b - other_T_a_b * middle_b).norm() < kSameShiftM &&
         RotationAngle(T_a_b.Inverse() * other_T_a_b) < kSameTurnRad;
}

std::vector<Pose> MovedByRepeats(const PreparedMap& a, const PreparedMap& b, const Pose& T_a_b) {
  std::vector<Pose> moved;
  for (const Pose& T_a_a : a.self_similarity().Moves(kMaxRepeats)) moved.push_back(T_a_a * T_a_b);
  for (const Pose& T_b_b : b.self_similarity().Moves(kMaxRepeats)) moved.push_back(T_a_b * T_b_b);
  return moved;
}

bool IsSamePlace(const JointRefinement& joint, const JointRefinement& other) {
  size_t same = 0;
  for (const SubmapEdge& edge : joint.edges) {
    const Pose T_there = other.poses.a[edge.submap_a].Inverse() * other.poses.b[edge.submap_b];
    same += AreNear(edge.T_a_b, T_there, kSameShiftM, kSameTurnRad);
  }
  return 2 * same > joint.edges.size();
}

void MeasureJointly(const PreparedMap& a, const PreparedMap& b, Hypothesis* h) {
  Measure(a, b, Of::kWindows, h);
}

void MeasurePair(const PreparedMap& a, const PreparedMap& b, Hypothesis* h) {
  Measure(a, b, Of::kSessions, h);
}

void ExtendJointly(const PreparedMap& a, const PreparedMap& b, size_t first_a, size_t first_b,
                   Hypothesis* h) {
  const MapPoses before = h->joint.poses;
  PlaceNew(a.submaps(), Pose(), &h->joint.poses.a);
  PlaceNew(b.submaps(), h->T_a_b, &h->joint.poses.b);
  // If all aligned submaps were retired, the others are aligned, from the poses that these left
  // them.
  const bool lost = h->joint.edges.empty();
  // If the new submaps meet nothing, the earlier result holds.
  if (RefineJointly(a, b, kKnownGateM, lost ? 0 : first_a, lost ? 0 : first_b, &h->joint)) {
    h->converged = true;
    h->T_a_b = h->joint.T_a_b;
    h->odometry_residual = h->joint.odometry_residual;
  }
  const MapPoses& after = h->joint.poses;
  const bool anew = HasMoved(before.a, after.a) || HasMoved(before.b, after.b);
  const bool was_b = std::exchange(h->moving_is_b, SurfaceSize(b) <= SurfaceSize(a));
  const bool all = anew || was_b != h->moving_is_b;
  const auto asked_a = [&](size_t k) {
    return all || k >= first_a || MeetsNew(*a.submaps()[k], after.a[k], b, after.b, first_b);
  };
  const auto asked_b = [&](size_t k) {
    return all || k >= first_b || MeetsNew(*b.submaps()[k], after.b[k], a, after.a, first_a);
  };
  const auto asked_moving = [&](size_t k) { return h->moving_is_b ? asked_b(k) : asked_a(k); };
  MeasureSurface(a, b, Of::kSessions, asked_moving, h);
  if (!h->outdoors) MeasureThings(a, b, asked_a, asked_b, h);
  if (anew) h->free_space = {};
  h->free_space +=
      ScoreFreeSpace(a.free_space(), b.free_space(), after, FreeSpaceOptions::For(h->outdoors),
                     anew ? 0 : first_a, anew ? 0 : first_b);
}

void KeepOnly(const std::vector<size_t>& kept_a, const std::vector<size_t>& kept_b, Hypothesis* h) {
  Reduce(kept_a, &h->joint.poses.a);
  Reduce(kept_b, &h->joint.poses.b);
  Reduce(h->moving_is_b ? kept_b : kept_a, &h->agreement);
  Reduce(kept_a, &h->things_a);
  Reduce(kept_b, &h->things_b);
  const auto move_edge = [&](SubmapEdge* edge) {
    return MovePositions(kept_a, kept_b, &edge->submap_a, &edge->submap_b);
  };
  KeepMoved(move_edge, &h->joint.edges);
  KeepMoved(move_edge, &h->joint.ties);
  KeepMoved([&](PositionPair* pair) { return MovePositions(kept_a, kept_b, &pair->a, &pair->b); },
            &h->meetings.in_vain);
  h->meetings.asked_a = CountBelow(kept_a, h->meetings.asked_a);
  h->meetings.asked_b = CountBelow(kept_b, h->meetings.asked_b);
}

}  // namespace isthmus::matching
