#include "server/pose_graph/chordal.h"

#include <Eigen/SVD>
#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>

#include "server/pose_graph/g2o.h"
#include "server/pose_graph/gauge.h"
#include "server/pose_graph/limits.h"

namespace isthmus::pose_graph {
namespace {

constexpr int kHeld = -1;  // Layout.

// Normal equations of residuals x_b - M x_a of unknown blocks of `size` rows and 3 columns.
class Normals {
 public:
  Normals(int blocks, int size)
      : size_(size), right_(Eigen::MatrixXd::Zero(Eigen::Index{blocks} * size, 3)) {}

  // |x_row - ...|^2 has weight * block as its derivative twice, by x_row and x_column.
  void Add(int row, int column, const Eigen::MatrixXd& block) {
    for (int i = 0; i < size_; ++i) {
      for (int j = 0; j < size_; ++j) {
        if (block(i, j) != 0)
          entries_.emplace_back(row * size_ + i, column * size_ + j, block(i, j));
      }
    }
  }

  void AddRight(int row, const Eigen::MatrixXd& block) {
    right_.middleRows(Eigen::Index{row} * size_, size_) += block;
  }

  std::optional<Eigen::MatrixXd> Solve() const {
    if (right_.rows() == 0) return right_;
    Eigen::SparseMatrix<double> matrix(right_.rows(), right_.rows());
    matrix.setFromTriplets(entries_.begin(), entries_.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
    if (solver.info() != Eigen::Success) return std::nullopt;
    const Eigen::MatrixXd solution = solver.solve(right_);
    if (!solution.allFinite()) return std::nullopt;
    return solution;
  }

 private:
  const int size_;
  std::vector<Eigen::Triplet<double>> entries_;
  Eigen::MatrixXd right_;
};

// The precision of an edge, per axis.
struct Precision {
  double translation = 0, rotation = 0;
};

Precision PrecisionOf(const Edge& edge) {
  const Matrix6d g2o = ToG2oInformation(edge.information, edge.T_a_b);
  const double translation = g2o.topLeftCorner<3, 3>().trace() / 3;
  const double rotation = g2o.bottomRightCorner<3, 3>().trace() / 12;  // q is half a turn.
  return {std::max(translation, kLeastEdgeInformation), std::max(rotation, kLeastEdgeInformation)};
}

Eigen::Quaterniond NearestRotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant());
  return Eigen::Quaterniond(
      Eigen::Matrix3d(svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose()));
}

class Chordal {
 public:
  explicit Chordal(const Problem& problem) : problem_(problem), poses_(problem.poses) {
    Problem without_anchors{problem.poses, problem.edges, {}, problem.fixed};
    unknown_.assign(poses_.size(), 0);
    for (const int held : ChooseGauge(without_anchors).held) {
      unknown_[static_cast<size_t>(held)] = kHeld;
    }
    for (int& unknown : unknown_) {
      if (unknown != kHeld) unknown = count_++;
    }
    for (const Edge& edge : problem.edges) precisions_.push_back(PrecisionOf(edge));
  }

  std::optional<std::vector<Pose>> Solve() {
    if (!SolveRotations() || !SolveTranslations()) return std::nullopt;
    return poses_;
  }

 private:
  int Unknown(int node) const { return unknown_[static_cast<size_t>(node)]; }

  // The unknowns are transposed: R_b^T = R_a_b^T R_a^T.
  bool SolveRotations() {
    Normals normals(count_, 3);
    for (size_t i = 0; i < problem_.edges.size(); ++i) {
      const Edge& edge = problem_.edges[i];
      const double weight = precisions_[i].rotation;
      const Eigen::Matrix3d M = edge.T_a_b.RotationMatrix();
      const int a = Unknown(edge.a), b = Unknown(edge.b);
      if (a != kHeld) normals.Add(a, a, weight * Eigen::Matrix3d::Identity());
      if (b != kHeld) normals.Add(b, b, weight * Eigen::Matrix3d::Identity());
      if (a != kHeld && b != kHeld) {
        normals.Add(a, b, -weight * M);
        normals.Add(b, a, -weight * M.transpose());
      } else if (a != kHeld) {
        normals.AddRight(a, weight * M * Transposed(edge.b));
      } else if (b != kHeld) {
        normals.AddRight(b, weight * M.transpose() * Transposed(edge.a));
      }
    }
    const auto solution = normals.Solve();
    if (!solution) return false;
    for (size_t i = 0; i < poses_.size(); ++i) {
      if (unknown_[i] == kHeld) continue;
      const Eigen::Matrix3d transposed = solution->middleRows<3>(Eigen::Index{3} * unknown_[i]);
      poses_[i] = Pose(NearestRotation(transposed.transpose()), poses_[i].translation());
    }
    return true;
  }

  bool SolveTranslations() {
    Normals normals(count_, 1);
    const Eigen::Matrix<double, 1, 1> one(1);
    for (size_t i = 0; i < problem_.edges.size(); ++i) {
      const Edge& edge = problem_.edges[i];
      const double weight = precisions_[i].translation;
      const Pose& T_map_a = poses_[static_cast<size_t>(edge.a)];
      const Pose& T_map_b = poses_[static_cast<size_t>(edge.b)];
      const Eigen::RowVector3d step = (T_map_a.rotation() * edge.T_a_b.translation()).transpose();
      const int a = Unknown(edge.a), b = Unknown(edge.b);
      if (a != kHeld) {
        normals.Add(a, a, weight * one);
        normals.AddRight(a, -weight * step);
        if (b == kHeld) normals.AddRight(a, weight * T_map_b.translation().transpose());
      }
      if (b != kHeld) {
        normals.Add(b, b, weight * one);
        normals.AddRight(b, weight * step);
        if (a == kHeld) normals.AddRight(b, weight * T_map_a.translation().transpose());
      }
      if (a == kHeld || b == kHeld) continue;
      normals.Add(a, b, -weight * one);
      normals.Add(b, a, -weight * one);
    }
    const auto solution = normals.Solve();
    if (!solution) return false;
    for (size_t i = 0; i < poses_.size(); ++i) {
      if (unknown_[i] == kHeld) continue;
      poses_[i] = Pose(poses_[i].rotation(), solution->row(unknown_[i]).transpose());
    }
    return true;
  }

  Eigen::Matrix3d Transposed(int node) const {
    return poses_[static_cast<size_t>(node)].RotationMatrix().transpose();
  }

  const Problem& problem_;
  std::vector<Pose> poses_;
  std::vector<int> unknown_;  // The place of each node among the unknown ones, or kHeld.
  int count_ = 0;
  std::vector<Precision> precisions_;  // By edge.
};

double Disagreement(const Problem& problem, const std::vector<Pose>& poses, double doubt_chi2) {
  const Problem now{poses, {}, {}, {}};
  double cost = 0;
  for (const Edge& edge : problem.edges) {
    const double chi2 = Chi2(now, edge);
    cost += edge.may_be_wrong ? doubt_chi2 * std::log1p(chi2 / doubt_chi2) : chi2;
  }
  return cost;
}

}  // namespace

std::optional<std::vector<Pose>> ChordalPoses(const Problem& problem) {
  return Chordal(problem).Solve();
}

std::optional<std::vector<Pose>> BetterStart(const Problem& problem, double doubt_chi2) {
  std::optional<std::vector<Pose>> chordal = ChordalPoses(problem);
  if (!chordal || !(Disagreement(problem, *chordal, doubt_chi2) <
                    Disagreement(problem, problem.poses, doubt_chi2))) {
    return std::nullopt;
  }
  return chordal;
}

}  // namespace isthmus::pose_graph
