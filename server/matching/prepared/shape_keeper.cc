#include "server/matching/prepared/shape_keeper.h"

#include <algorithm>
#include <optional>

#include "server/matching/prepared/limits.h"
#include "server/pose_graph/information.h"
#include "server/pose_graph/optimize.h"

namespace isthmus::matching {
namespace {

// The place of a submap in a list in order of index.
std::optional<size_t> PositionOf(const SubmapList& submaps, uint32_t index) {
  const auto at = std::lower_bound(
      submaps.begin(), submaps.end(), index,
      [](const auto& submap, uint32_t wanted) { return submap->id.index < wanted; });
  if (at == submaps.end() || (*at)->id.index != index) return std::nullopt;
  return static_cast<size_t>(at - submaps.begin());
}

const Pose* FindPublished(const Placement* placement, uint32_t index) {
  if (placement == nullptr) return nullptr;
  for (const SubmapPose& submap : placement->submaps) {
    if (submap.index == index) return &submap.T_map_submap;
  }
  return nullptr;
}

bool IsUsable(const SubmapEdge& edge) {
  return edge.submap_a != edge.submap_b && edge.T_a_b.IsFinite() &&
         pose_graph::SquareRootInformation(edge.information).ok();
}

bool IsAt(const Pose& pose, const Pose& other) { return pose.Matrix() == other.Matrix(); }

}  // namespace

void ShapeKeeper::FindGaps(const SubmapList& submaps, const Placement* published) {
  std::map<std::pair<uint32_t, uint32_t>, Pose> gaps;
  for (size_t k = 0; k + 1 < submaps.size(); ++k) {
    const uint32_t a = submaps[k]->id.index, b = submaps[k + 1]->id.index;
    if (b == a + 1) continue;
    const auto known = gaps_.find({a, b});
    if (known != gaps_.end()) {
      gaps.insert(*known);
      continue;
    }
    const auto in_a = PositionOf(given_, a), in_b = PositionOf(given_, b);
    const Pose *map_a = FindPublished(published, a), *map_b = FindPublished(published, b);
    if (in_a && in_b) {
      gaps[{a, b}] = shape_->best[*in_a].Inverse() * shape_->best[*in_b];
    } else if (map_a != nullptr && map_b != nullptr) {
      gaps[{a, b}] = map_a->Inverse() * *map_b;
    }
  }
  gaps_ = std::move(gaps);
}

std::vector<pose_graph::Edge> ShapeKeeper::Steps(const SubmapList& submaps,
                                                 const pose_graph::DriftModel& drift) const {
  std::vector<pose_graph::Edge> steps = OdometrySteps(submaps, drift);
  for (size_t k = 0; k < steps.size(); ++k) {
    const auto gap = gaps_.find({submaps[k]->id.index, submaps[k + 1]->id.index});
    if (gap == gaps_.end()) continue;
    steps[k].T_a_b = gap->second;
    steps[k].information = pose_graph::OdometryInformation(gap->second, drift);
  }
  return steps;
}

ShapeKeeper::Loops ShapeKeeper::AddLoops(const SubmapList& submaps,
                                         const std::vector<LoopClosure>& loops,
                                         pose_graph::Problem* problem) const {
  Loops added;
  for (const LoopClosure& loop : loops) {
    for (uint32_t k = 0; k < loop.edges.size(); ++k) {
      const SubmapEdge& edge = loop.edges[k];
      const auto known = weights_.find({loop.id, k});
      if (loop.rejected) {
        added.taken_back |= known != weights_.end();
        continue;
      }
      const auto a = PositionOf(submaps, edge.submap_a), b = PositionOf(submaps, edge.submap_b);
      if (!a || !b || !IsUsable(edge)) continue;
      added.any_new |= known == weights_.end();
      problem->edges.push_back({static_cast<int>(*a), static_cast<int>(*b), edge.T_a_b,
                                edge.information, true,
                                known == weights_.end() ? 1 : known->second});
      added.keys.emplace_back(loop.id, k);
    }
  }
  return added;
}

void ShapeKeeper::SetPoses(const SubmapList& submaps, const Loops& loops,
                           pose_graph::Problem* problem) const {
  for (size_t k = 0; k < submaps.size(); ++k) {
    const Submap& submap = *submaps[k];
    const auto known = loops.taken_back ? std::nullopt : PositionOf(given_, submap.id.index);
    // A submap that nothing has moved lies as odometry has it, to the last digit.
    const bool by_odometry =
        k == 0 || (IsAt(problem->poses[k - 1], submaps[k - 1]->T_odom_submap) &&
                   !gaps_.contains({submaps[k - 1]->id.index, submap.id.index}));
    problem->poses.push_back(known         ? shape_->best[*known]
                             : by_odometry ? submap.T_odom_submap
                                           : problem->poses[k - 1] * problem->edges[k - 1].T_a_b);
  }
  problem->fixed = {0};
}

SessionShape ShapeKeeper::Solve(const SubmapList& submaps, const std::vector<LoopClosure>& known,
                                bool* taken_back) {
  pose_graph::Problem problem;
  problem.edges = Steps(submaps, kPoorOdometry);
  const size_t steps = problem.edges.size();
  const Loops loops = AddLoops(submaps, known, &problem);
  *taken_back = loops.taken_back;
  SetPoses(submaps, loops, &problem);
  if (!loops.keys.empty() && (loops.any_new || loops.taken_back)) {
    pose_graph::Options options;
    options.go_on = !weights_.empty() && !loops.taken_back;
    options.max_seconds = kMaxShapeSeconds;
    if (const auto solved = pose_graph::Optimize(problem, options); solved.ok()) {
      problem.poses = solved->poses;
      for (size_t k = steps; k < problem.edges.size(); ++k) {
        problem.edges[k].weight = solved->edge_weights[k] > 0.5 ? 1 : 0;
      }
    }
  }
  SessionShape shape;
  shape.edges = Steps(submaps, {});
  weights_.clear();
  for (size_t k = steps; k < problem.edges.size(); ++k) {
    pose_graph::Edge& edge = problem.edges[k];
    weights_[loops.keys[k - steps]] = edge.weight;
    edge.may_be_wrong = false;  // It was judged here.
    if (edge.weight > 0) shape.edges.push_back(edge);
  }
  const double scale = DriftScale(problem, shape.edges, steps);
  for (size_t k = 0; k < steps; ++k) shape.edges[k].information /= scale;
  if (!loops.keys.empty() && (loops.any_new || loops.taken_back)) {
    // Solves for poses at which these edges agree best, or a match's part could not be told.
    pose_graph::Options options{.max_seconds = kMaxShapeSeconds, .judge = false};
    problem.edges = shape.edges;
    const auto solved = pose_graph::Optimize(problem, options);
    if (solved.ok()) problem.poses = solved->poses;
  }
  for (const auto& submap : submaps) shape.odometry.push_back(submap->T_odom_submap);
  shape.best = std::move(problem.poses);
  return shape;
}

std::vector<Pose> ShapeKeeper::PosesToHold(const SubmapList& submaps, const SessionShape& shape,
                                           bool may_move, bool* moved) const {
  std::vector<Pose> held, best;  // Poses of submaps that were there before.
  for (size_t k = 0; k < submaps.size(); ++k) {
    const auto before = PositionOf(held_, submaps[k]->id.index);
    if (!before) continue;
    held.push_back(held_[*before]->T_odom_submap);
    best.push_back(shape.best[k]);
  }
  if (held.empty()) return shape.best;
  const ShapeFit fit = FitShape(best, held);
  const bool is_same = fit.farthest_m == 0;
  *moved = may_move && fit.farthest_m > kReshapedM;
  std::vector<Pose> poses = shape.best;
  for (size_t k = 0; k < submaps.size() && !*moved; ++k) {
    const auto before = PositionOf(held_, submaps[k]->id.index);
    if (before) {
      poses[k] = held_[*before]->T_odom_submap;
    } else if (!is_same) {
      poses[k] = fit.T_to_from * shape.best[k];
    }
  }
  return poses;
}

void ShapeKeeper::Hold(const SubmapList& submaps, const std::vector<Pose>& poses) {
  SubmapList held;
  for (size_t k = 0; k < submaps.size(); ++k) {
    const auto before = PositionOf(held_, submaps[k]->id.index);
    const bool same = before && IsAt(held_[*before]->T_odom_submap, poses[k]);
    held.push_back(same ? held_[*before] : LyingAt(submaps[k], poses[k]));
  }
  held_ = std::move(held);
}

bool ShapeKeeper::Update(const SubmapList& submaps, const std::vector<LoopClosure>& loops,
                         bool finished, const Placement* published) {
  FindGaps(submaps, published);
  bool taken_back = false;
  auto shape = std::make_shared<const SessionShape>(Solve(submaps, loops, &taken_back));
  const bool grown =
      static_cast<double>(submaps.size()) >= kReshapeGrowth * static_cast<double>(shaped_at_);
  bool moved = false;
  Hold(submaps, PosesToHold(submaps, *shape, finished || taken_back || grown, &moved));
  if (moved || (given_.empty() && !weights_.empty())) shaped_at_ = submaps.size();
  given_ = submaps;
  shape_ = std::move(shape);
  return moved;
}

}  // namespace isthmus::matching
