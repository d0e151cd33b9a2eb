#include "server/pose_graph/optimize_around.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

#include "absl/strings/str_cat.h"
#include "core/geometry/se3.h"
#include "server/pose_graph/gauge.h"
#include "server/pose_graph/validate.h"

namespace isthmus::pose_graph {
namespace {

// An edge or anchor that was discarded before.
template <typename Tie>
bool LeftOut(const Tie& tie) {
  return tie.may_be_wrong && tie.weight < 0.5;
}

class Region {
 public:
  Region(const Problem& problem, const RegionOptions& options)
      : problem_(problem),
        options_(options),
        poses_(problem.poses),
        free_(poses_.size(), false),
        held_(poses_.size(), false),
        hangs_(poses_.size(), false),
        weights_(problem.edges.size(), 1),
        touching_(poses_.size()) {
    for (size_t i = 0; i < problem.edges.size(); ++i) {
      const Edge& edge = problem.edges[i];
      if (LeftOut(edge)) weights_[i] = 0;
      if (weights_[i] == 0) continue;
      touching_[Index(edge.a)].push_back(i);
      touching_[Index(edge.b)].push_back(i);
    }
    gauge_ = ChooseGauge(problem);
    for (const int node : gauge_.held) held_[Index(node)] = true;
    for (const Anchor& anchor : problem.anchors) {
      result_.anchor_weights.push_back(LeftOut(anchor) ? 0 : 1);
    }
    SetRigidBranchesAside();
  }

  void Begin(const std::vector<int>& new_edges) {
    std::vector<int> seeds;
    for (const int index : new_edges) {
      const Edge& edge = problem_.edges[Index(index)];
      if (hangs_[Index(edge.a)] || hangs_[Index(edge.b)]) continue;
      for (const int node : Way(edge, Index(index))) seeds.push_back(node);
    }
    Free(seeds, options_.neighbourhood);
  }

  absl::StatusOr<Result> Run() {
    for (int growth = 0;; ++growth) {
      const absl::Status status = Solve();
      if (!status.ok()) return status;
      const std::vector<int> restless = Restless();
      if (restless.empty()) break;
      if (growth >= options_.max_growths) {
        for (size_t i = 0; i < free_.size(); ++i) free_[i] = !hangs_[i];
      } else {
        Free(restless, options_.neighbourhood + growth);
      }
    }
    LetRigidBranchesFollow();
    result_.poses = poses_;
    result_.edge_weights = weights_;
    result_.held = gauge_.held;
    return result_;
  }

 private:
  static constexpr int kNoNode = -1;

  static size_t Index(int i) { return static_cast<size_t>(i); }
  static int Other(const Edge& edge, int node) { return edge.a == node ? edge.b : edge.a; }

  // Takes out nodes that hang on the rest by one edge, leaf by leaf.
  void SetRigidBranchesAside() {
    std::vector<bool> stays = held_;
    for (size_t i = 0; i < problem_.anchors.size(); ++i) {
      if (result_.anchor_weights[i] != 0) stays[Index(problem_.anchors[i].node)] = true;
    }
    std::vector<int> leaves;
    const auto add_leaf = [&](int node) {
      if (touching_[Index(node)].size() == 1 && !stays[Index(node)]) leaves.push_back(node);
    };
    for (size_t i = 0; i < poses_.size(); ++i) add_leaf(static_cast<int>(i));
    for (size_t next = 0; next < leaves.size(); ++next) {
      const int leaf = leaves[next];
      if (touching_[Index(leaf)].empty()) continue;  // Its only neighbour went before.
      const size_t edge = touching_[Index(leaf)].front();
      const int other = Other(problem_.edges[edge], leaf);
      touching_[Index(leaf)].clear();
      std::erase(touching_[Index(other)], edge);
      hangs_[Index(leaf)] = true;
      rigid_branches_.push_back({leaf, edge});
      add_leaf(other);
    }
  }

  // Places the rigid branches exactly as their edges say.
  void LetRigidBranchesFollow() {
    for (auto branch = rigid_branches_.rbegin(); branch != rigid_branches_.rend(); ++branch) {
      const Edge& edge = problem_.edges[branch->edge];
      const Pose& on = poses_[Index(Other(edge, branch->node))];
      poses_[Index(branch->node)] =
          on * (edge.b == branch->node ? edge.T_a_b : edge.T_a_b.Inverse());
    }
  }

  // The nodes on the shortest way from one end of an edge to the other without it; the ends alone
  // when there is none.
  std::vector<int> Way(const Edge& edge, size_t index) const {
    std::vector<int> from(poses_.size(), kNoNode), open = {edge.a};
    from[Index(edge.a)] = edge.a;
    for (size_t next = 0; next < open.size() && from[Index(edge.b)] == kNoNode; ++next) {
      for (const size_t i : touching_[Index(open[next])]) {
        const int node = Other(problem_.edges[i], open[next]);
        if (i == index || from[Index(node)] != kNoNode) continue;
        from[Index(node)] = open[next];
        open.push_back(node);
      }
    }
    std::vector<int> way = {edge.a, edge.b};
    if (from[Index(edge.b)] == kNoNode) return way;
    for (int node = from[Index(edge.b)]; node != edge.a; node = from[Index(node)]) {
      way.push_back(node);
    }
    return way;
  }

  // Lets nodes move, and those up to `rings` edges away.
  void Free(std::vector<int> nodes, int rings) {
    for (const int node : nodes) free_[Index(node)] = true;
    for (int ring = 0; ring < rings; ++ring) {
      std::vector<int> next;
      for (const int node : nodes) {
        for (const size_t i : touching_[Index(node)]) {
          const int other = Other(problem_.edges[i], node);
          if (free_[Index(other)]) continue;
          free_[Index(other)] = true;
          next.push_back(other);
        }
      }
      nodes = std::move(next);
    }
  }

  // The region's edges, with its nodes and the held ones beside it, as a problem of its own. Nodes
  // keep their order, so that its gauge is the same.
  absl::Status Solve() {
    std::vector<int> number(poses_.size(), kNoNode);
    std::vector<size_t> nodes, edges, anchors;
    const auto is_free = [&](int node) { return free_[Index(node)] && !held_[Index(node)]; };
    for (size_t i = 0; i < problem_.edges.size(); ++i) {
      const Edge& edge = problem_.edges[i];
      if (LeftOut(edge) || hangs_[Index(edge.a)] || hangs_[Index(edge.b)]) continue;
      if (is_free(edge.a) || is_free(edge.b)) {
        edges.push_back(i);
        number[Index(edge.a)] = number[Index(edge.b)] = 0;
      }
    }
    Problem part;
    for (size_t i = 0; i < poses_.size(); ++i) {
      if (number[i] == kNoNode) continue;
      number[i] = static_cast<int>(nodes.size());
      nodes.push_back(i);
      part.poses.push_back(poses_[i]);
      if (!is_free(static_cast<int>(i))) part.fixed.push_back(number[i]);
    }
    for (const size_t i : edges) {
      part.edges.push_back(problem_.edges[i]);
      part.edges.back().a = number[Index(problem_.edges[i].a)];
      part.edges.back().b = number[Index(problem_.edges[i].b)];
    }
    for (size_t i = 0; i < problem_.anchors.size(); ++i) {
      const int node = number[Index(problem_.anchors[i].node)];
      if (node == kNoNode || !is_free(problem_.anchors[i].node) || LeftOut(problem_.anchors[i])) {
        continue;
      }
      anchors.push_back(i);
      part.anchors.push_back(problem_.anchors[i]);
      part.anchors.back().node = node;
    }
    auto solved = Optimize(part, options_.solver);
    if (!solved.ok()) return solved.status();
    for (size_t k = 0; k < nodes.size(); ++k) poses_[nodes[k]] = solved->poses[k];
    for (size_t k = 0; k < edges.size(); ++k) weights_[edges[k]] = solved->edge_weights[k];
    for (size_t k = 0; k < anchors.size(); ++k) {
      result_.anchor_weights[anchors[k]] = solved->anchor_weights[k];
    }
    result_.iterations += solved->iterations;
    result_.converged = solved->converged;
    result_.initial_chi2 = solved->initial_chi2;
    result_.final_chi2 = solved->final_chi2;
    result_.free_nodes = solved->free_nodes;
    return absl::OkStatus();
  }

  // Held nodes beside the region that would go farther than the tolerance.
  std::vector<int> Restless() const {
    std::vector<bool> beside(poses_.size(), false);
    for (size_t i = 0; i < problem_.edges.size(); ++i) {
      const Edge& edge = problem_.edges[i];
      if (weights_[i] == 0 || free_[Index(edge.a)] == free_[Index(edge.b)]) continue;
      if (hangs_[Index(edge.a)] || hangs_[Index(edge.b)]) continue;
      beside[Index(free_[Index(edge.a)] ? edge.b : edge.a)] = true;
    }
    std::vector<int> restless;
    for (size_t i = 0; i < beside.size(); ++i) {
      if (!beside[i] || held_[i]) continue;
      const Vector6d step = OwnStep(static_cast<int>(i));
      if (step.head<3>().norm() > options_.position_tolerance_m ||
          step.tail<3>().norm() > options_.rotation_tolerance_rad) {
        restless.push_back(static_cast<int>(i));
      }
    }
    return restless;
  }

  // The Gauss-Newton step of one node, all others held: a twist on its right.
  Vector6d OwnStep(int node) const {
    Matrix6d H = Matrix6d::Zero();
    Vector6d g = Vector6d::Zero();
    for (const size_t i : touching_[Index(node)]) {
      const Edge& edge = problem_.edges[i];
      const Pose& T_map_a = poses_[Index(edge.a)];
      const Pose& T_map_b = poses_[Index(edge.b)];
      const Vector6d e = EdgeError(T_map_a, T_map_b, edge.T_a_b);
      Matrix6d J = InverseLeftJacobian(e);
      J = node == edge.a ? Matrix6d(-J) : Matrix6d(J * Adjoint(T_map_a.Inverse() * T_map_b));
      H += weights_[i] * J.transpose() * edge.information * J;
      g += weights_[i] * J.transpose() * (edge.information * e);
    }
    for (size_t i = 0; i < problem_.anchors.size(); ++i) {
      const Anchor& anchor = problem_.anchors[i];
      if (anchor.node != node || result_.anchor_weights[i] == 0) continue;
      const Vector6d e = AnchorError(poses_[Index(node)], anchor.T_map_node);
      const Eigen::Matrix3d R = poses_[Index(node)].RotationMatrix();
      Matrix6d J = Matrix6d::Zero();
      J.topLeftCorner<3, 3>() = R;
      J.bottomRightCorner<3, 3>() = InverseLeftJacobian(Eigen::Vector3d(e.tail<3>())) * R;
      H += J.transpose() * anchor.information * J;
      g += J.transpose() * (anchor.information * e);
    }
    const double floor = 1e-9 * std::max(H.diagonal().maxCoeff(), 1e-12);
    H.diagonal().array() += floor;
    return H.ldlt().solve(-g);
  }

  const Problem& problem_;
  const RegionOptions& options_;
  std::vector<Pose> poses_;
  std::vector<bool> free_, held_;  // In the region; held by the gauge, free or not.
  std::vector<bool> hangs_;
  struct RigidBranch {
    int node = 0;
    size_t edge = 0;
  };
  std::vector<RigidBranch> rigid_branches_;  // Each on one that comes later or stays.
  std::vector<double> weights_;
  std::vector<std::vector<size_t>> touching_;  // Edges that count, by node; not of rigid branches.
  Gauge gauge_;
  Result result_;
};

}  // namespace

absl::StatusOr<Result> OptimizeAround(const Problem& problem, const std::vector<int>& new_edges,
                                      const RegionOptions& options) {
  const absl::Status valid = Validate(problem, options.solver);
  if (!valid.ok()) return valid;
  for (const int edge : new_edges) {
    if (edge < 0 || static_cast<size_t>(edge) >= problem.edges.size()) {
      return absl::InvalidArgumentError(absl::StrCat(
          "new edge ", edge, " does not exist; there are ", problem.edges.size(), " edges"));
    }
  }
  Region region(problem, options);
  region.Begin(new_edges);
  return region.Run();
}

}  // namespace isthmus::pose_graph
