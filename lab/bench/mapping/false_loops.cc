#include "lab/bench/mapping/false_loops.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "client/evaluation/trajectory_error.h"
#include "lab/bench/cpu_clock.h"
#include "lab/bench/mapping/map_truth.h"
#include "lab/simulation/random.h"

namespace isthmus::bench {
namespace {

using simulation::Random;

constexpr int kTwinSubmaps = 5;
constexpr double kOffM = 6;  // Offset of false poses, at most along either axis.

Pose RandomOffset(Random& random) {
  const double x = random.Uniform(-kOffM, kOffM), y = random.Uniform(-kOffM, kOffM);
  return Pose::FromXyzRpy(x, y, 0, 0, 0, random.Uniform(-std::numbers::pi, std::numbers::pi));
}

// Two submaps that have `apart` others between them or more; `last` more follow either.
std::pair<uint32_t, uint32_t> TwoSubmaps(size_t count, int last, int apart, Random& random) {
  const int places = static_cast<int>(count) - last;
  int a = 0, b = 0;
  do {
    a = random.Index(places);
    b = random.Index(places);
  } while (b - a <= apart);
  return {static_cast<uint32_t>(a), static_cast<uint32_t>(b)};
}

// A right edge, at a place that is near to where it should be.
LoopClosure NearLoop(const DrivenRobot& robot, const std::vector<SubmapEdge>& right,
                     Random& random) {
  SubmapEdge edge = right[random.Index(static_cast<int>(right.size()))];
  const double far = random.Uniform(1, 4), towards = random.Uniform(0, 2 * std::numbers::pi);
  const double turn = random.Uniform(-15, 15) * std::numbers::pi / 180;
  edge.T_a_b = Pose::FromXyzRpy(far * std::cos(towards), far * std::sin(towards), 0, 0, 0, 0) *
               edge.T_a_b * Pose::FromXyzRpy(0, 0, 0, 0, 0, turn);
  LoopClosure loop;
  loop.session = robot.session.id;
  loop.submap_a = edge.submap_a;
  loop.submap_b = edge.submap_b;
  loop.T_a_b = edge.T_a_b;
  loop.confidence = 1;
  loop.edges = {edge};
  return loop;
}

// A loop of `edges` edges, from submaps a + i to b + i, as odometry has both stretches.
LoopClosure FalseLoop(const DrivenRobot& robot, int edges, const Matrix6d& information,
                      Random& random) {
  const auto [a, b] = TwoSubmaps(robot.submaps.size(), edges - 1, edges, random);
  const auto odom = [&](uint32_t i) { return robot.submaps[i]->T_odom_submap; };
  const Pose T_a_b = RandomOffset(random);
  LoopClosure loop;
  loop.session = robot.session.id;
  loop.submap_a = a;
  loop.submap_b = b;
  loop.T_a_b = T_a_b;
  loop.confidence = 1;
  for (uint32_t i = 0; i < static_cast<uint32_t>(edges); ++i) {
    const Pose T_ai_a = odom(a + i).Inverse() * odom(a), T_b_bi = odom(b).Inverse() * odom(b + i);
    loop.edges.push_back({a + i, b + i, T_ai_a * T_a_b * T_b_bi, information});
  }
  return loop;
}

placement::Input InputOf(const DrivenRobot& robot, std::vector<LoopClosure> loops) {
  placement::Session session;
  session.tree.session = session.tree.reference = robot.session.id;
  for (const auto& submap : robot.submaps) {
    session.nodes.push_back({.index = submap->id.index,
                             .T_odom_submap = submap->T_odom_submap,
                             .drift_covariance = submap->drift_covariance});
  }
  placement::Input input;
  input.sessions = {std::move(session)};
  input.loops = std::move(loops);
  return input;
}

// The error over all keyframes, with the submaps as placed.
double RmseOf(const DrivenRobot& robot, const placement::Outcome& outcome) {
  DrivenRobot placed = robot;
  for (const Placement& placement : outcome.placements) {
    for (const SubmapPose& pose : placement.submaps) {
      auto moved = std::make_shared<Submap>(*placed.submaps.at(pose.index));
      moved->T_odom_submap = pose.T_map_submap;
      placed.submaps[pose.index] = std::move(moved);
    }
  }
  const auto rmse = OpenLoopRmse(placed);
  return rmse.ok() ? *rmse : std::nan("");
}

struct Kept {
  size_t kept = 0, lost = 0;
};

Kept CountKept(const placement::EdgeStatus& edge_status, const std::vector<LoopClosure>& loops,
               size_t from, size_t to) {
  Kept count;
  for (size_t i = from; i < to; ++i) {
    const auto it = edge_status.loops.find(loops[i].id);
    for (size_t e = 0; e < loops[i].edges.size(); ++e) {
      const bool kept = it != edge_status.loops.end() && e < it->second.size() && it->second[e];
      ++(kept ? count.kept : count.lost);
    }
  }
  return count;
}

size_t EdgesOf(const std::vector<LoopClosure>& loops) {
  size_t edges = 0;
  for (const LoopClosure& loop : loops) edges += loop.edges.size();
  return edges;
}

}  // namespace

size_t AddFalseLoops(FalseKind kind, double share, uint64_t seed, const DrivenRobot& robot,
                     std::vector<LoopClosure>* loops) {
  const int each = kind == FalseKind::kTwins ? kTwinSubmaps : 1;
  const size_t right = EdgesOf(*loops);
  const auto wanted =
      static_cast<size_t>(std::ceil(static_cast<double>(right) * share / (1 - share) - 1e-9));
  if (right == 0 || robot.submaps.size() < 4 * static_cast<size_t>(each)) return 0;
  uint64_t id = 0;
  std::vector<SubmapEdge> there;
  for (const LoopClosure& loop : *loops) {
    id = std::max(id, loop.id);
    there.insert(there.end(), loop.edges.begin(), loop.edges.end());
  }
  Random random(seed, 0xFA, static_cast<uint64_t>(kind));
  size_t added = 0;
  while (added < wanted) {
    const Matrix6d& like = there[random.Index(static_cast<int>(there.size()))].information;
    loops->push_back(kind == FalseKind::kNear ? NearLoop(robot, there, random)
                                              : FalseLoop(robot, each, like, random));
    loops->back().id = ++id;
    added += static_cast<size_t>(each);
  }
  return added;
}

FalseLoopsTrial RunFalseLoops(const DrivenRobot& robot, const std::vector<LoopClosure>& found,
                              FalseKind kind, double share, uint64_t seed,
                              const placement::PlacerOptions& options) {
  FalseLoopsTrial trial;
  trial.seed = seed;
  trial.name = kind == FalseKind::kTwins ? "twins" : kind == FalseKind::kNear ? "near" : "random";
  trial.open_m = OpenLoopRmse(robot).value_or(std::nan(""));
  std::vector<LoopClosure> loops = found;
  trial.false_edges = AddFalseLoops(kind, share, seed, robot, &loops);
  trial.edges = EdgesOf(loops);
  const auto place = [&](const std::vector<LoopClosure>& offered, double* ms) {
    const placement::Input input = InputOf(robot, offered);
    const CpuClock clock;
    placement::Outcome outcome = placement::Placer(options).Place(input, {});
    *ms = clock.Ms();
    return outcome;
  };
  trial.without_m = RmseOf(robot, place(found, &trial.without_ms));
  const placement::Outcome outcome = place(loops, &trial.with_ms);
  trial.with_m = RmseOf(robot, outcome);
  trial.right_lost = CountKept(outcome.edge_status, loops, 0, found.size()).lost;
  trial.false_kept = CountKept(outcome.edge_status, loops, found.size(), loops.size()).kept;
  return trial;
}

}  // namespace isthmus::bench
