#include "server/pose_graph/least_squares.h"

#include <deque>
#include <exception>

#include "absl/strings/str_cat.h"
#include "server/pose_graph/ceres_terms.h"
#include "server/pose_graph/information.h"
#include "server/pose_graph/limits.h"

namespace isthmus::pose_graph {
namespace {

ceres::Problem::Options Owning() {
  ceres::Problem::Options options;
  // Terms, manifold and blocks live in vectors of CeresLeastSquares.
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;  // Validate has made them.
  return options;
}

ceres::Solver::Options SolverOptions(const LeastSquares::Effort& effort) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  // The damping of the default radius, 1e-4 of the diagonal, is far above what holds a long loop
  // together (about (pi / n)^2 of it for n nodes), so that loops would close step by step. Next to
  // none is Gauss-Newton; where that fails the radius shrinks by itself.
  options.initial_trust_region_radius = 1e10;
  options.max_trust_region_radius = 1e12;
  options.function_tolerance = effort.tolerance;
  options.parameter_tolerance = 1e-11;
  options.gradient_tolerance = 1e-8;
  options.max_num_iterations = effort.max_iterations;
  if (effort.max_seconds > 0) options.max_solver_time_in_seconds = effort.max_seconds;
  options.num_threads = effort.num_threads;
  options.logging_type = ceres::SILENT;
  return options;
}

class CeresLeastSquares : public LeastSquares {
 public:
  CeresLeastSquares(const Problem& problem, const Gauge& gauge) : problem_(problem), gauge_(gauge) {
    weights_.edges.assign(problem.edges.size(), 1.0);
    weights_.anchors.assign(problem.anchors.size(), 1.0);
    for (const Pose& pose : problem.poses) blocks_.push_back(ToBlock(pose));
  }

  // The terms of all edges and anchors.
  absl::Status MakeTerms() {
    for (size_t i = 0; i < problem_.edges.size(); ++i) {
      const Edge& edge = problem_.edges[i];
      const absl::StatusOr<Matrix6d> root = SquareRootInformation(edge.information);
      if (!root.ok()) {
        return absl::InvalidArgumentError(absl::StrCat("edge ", i, ": ", root.status().message()));
      }
      edge_terms_.emplace_back(edge.T_a_b, *root, &weights_.edges[i]);
    }
    for (size_t i = 0; i < problem_.anchors.size(); ++i) {
      const Anchor& anchor = problem_.anchors[i];
      const absl::StatusOr<Matrix6d> root = SquareRootInformation(anchor.information);
      if (!root.ok()) {
        return absl::InvalidArgumentError(
            absl::StrCat("anchor ", i, ": ", root.status().message()));
      }
      anchor_terms_.emplace_back(anchor.T_map_node, *root, &weights_.anchors[i]);
    }
    for (const int node : gauge_.steadied) {
      steadying_terms_.emplace_back(problem_.poses[static_cast<size_t>(node)],
                                    kSteadyingRoot * Matrix6d::Identity(), &one_);
    }
    return absl::OkStatus();
  }

  absl::StatusOr<Outcome> Solve(const Effort& effort) override {
    const std::vector<PoseBlock> before = blocks_;
    ceres::Solver::Summary summary;
    try {
      if (!IsAssembled()) Assemble();
      ceres::Solve(SolverOptions(effort), ceres_.get(), &summary);
    } catch (const std::exception& error) {
      blocks_ = before;
      return absl::InternalError(absl::StrCat("pose graph: ", error.what()));
    }
    if (!summary.IsSolutionUsable()) {
      blocks_ = before;
      return absl::InternalError(absl::StrCat("pose graph: ", summary.message));
    }
    return Outcome{static_cast<int>(summary.iterations.size()) - 1,
                   summary.termination_type == ceres::CONVERGENCE};
  }

  Weights& weights() override { return weights_; }

  std::vector<Pose> poses() const override {
    std::vector<Pose> poses;
    for (const PoseBlock& block : blocks_) poses.push_back(FromBlock(block.data()));
    return poses;
  }

  void set_poses(const std::vector<Pose>& poses) override {
    for (size_t i = 0; i < blocks_.size(); ++i) blocks_[i] = ToBlock(poses[i]);
  }

 private:
  double* Block(int node) { return blocks_[static_cast<size_t>(node)].data(); }

  // Terms of weight 0 are left out: their place in the sparse system would be filled in vain, which
  // a few hundred far-fetched edges make very slow.
  void Assemble() {
    ceres_ = std::make_unique<ceres::Problem>(Owning());
    for (PoseBlock& block : blocks_) ceres_->AddParameterBlock(block.data(), 7, &manifold_);
    for (const int held : gauge_.held) ceres_->SetParameterBlockConstant(Block(held));
    for (size_t i = 0; i < edge_terms_.size(); ++i) {
      if (weights_.edges[i] == 0) continue;
      const Edge& edge = problem_.edges[i];
      ceres_->AddResidualBlock(&edge_terms_[i], nullptr, Block(edge.a), Block(edge.b));
    }
    for (size_t i = 0; i < anchor_terms_.size(); ++i) {
      ceres_->AddResidualBlock(&anchor_terms_[i], nullptr, Block(problem_.anchors[i].node));
    }
    for (size_t i = 0; i < steadying_terms_.size(); ++i) {
      ceres_->AddResidualBlock(&steadying_terms_[i], nullptr, Block(gauge_.steadied[i]));
    }
    assembled_.clear();
    for (const double weight : weights_.edges) assembled_.push_back(weight != 0);
  }

  bool IsAssembled() const {
    if (ceres_ == nullptr) return false;
    for (size_t i = 0; i < assembled_.size(); ++i) {
      if (assembled_[i] != (weights_.edges[i] != 0)) return false;
    }
    return true;
  }

  const Problem& problem_;
  const Gauge gauge_;
  const double one_ = 1;
  Weights weights_;
  std::vector<PoseBlock> blocks_;
  PoseManifold manifold_;
  std::deque<EdgeTerm> edge_terms_;  // Ceres keeps their addresses.
  std::deque<AnchorTerm> anchor_terms_;
  std::deque<AnchorTerm> steadying_terms_;
  std::vector<bool> assembled_;            // The edges that ceres_ has.
  std::unique_ptr<ceres::Problem> ceres_;  // Last: it refers to all of the above.
};

}  // namespace

absl::StatusOr<std::unique_ptr<LeastSquares>> LeastSquares::Create(const Problem& problem,
                                                                   const Gauge& gauge) {
  auto least_squares = std::make_unique<CeresLeastSquares>(problem, gauge);
  const absl::Status status = least_squares->MakeTerms();
  if (!status.ok()) return status;
  return least_squares;
}

}  // namespace isthmus::pose_graph
