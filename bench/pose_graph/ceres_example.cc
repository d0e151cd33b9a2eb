#include "bench/pose_graph/ceres_example.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace isthmus::bench {
namespace {

struct Blocks {
  Eigen::Vector3d p;
  Eigen::Quaterniond q;
};

// Log(T_a^-1 T_b M^-1) of any scalar type, times the root of the information.
class ExampleError {
 public:
  explicit ExampleError(const pose_graph::Edge& edge)
      : inverse_(edge.T_a_b.Inverse()), root_(edge.information.llt().matrixU()) {}

  template <typename T>
  bool operator()(const T* p_a, const T* q_a, const T* p_b, const T* q_b, T* residual) const {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    using Quaternion = Eigen::Quaternion<T>;
    const Eigen::Map<const Vector3> pa(p_a), pb(p_b);
    const Eigen::Map<const Quaternion> qa(q_a), qb(q_b);
    const Quaternion q_ab = qa.conjugate() * qb;
    const Vector3 p_ab = qa.conjugate() * (pb - pa);
    const Quaternion q = q_ab * inverse_.rotation().template cast<T>();
    const Vector3 t = p_ab + q_ab * inverse_.translation().template cast<T>();
    const T quaternion[4] = {q.w(), q.x(), q.y(), q.z()};
    Vector3 phi;
    ceres::QuaternionToAngleAxis(quaternion, phi.data());
    // rho = V^-1 t = t - phi x t / 2 + c phi x (phi x t).
    const T squared = phi.squaredNorm();
    T c(1.0 / 12.0);
    if (squared > T(1e-6)) {
      const T angle = sqrt(squared);
      c = (T(1) - angle * T(0.5) / tan(angle * T(0.5))) / squared;
    }
    const Vector3 cross = phi.cross(t);
    Eigen::Matrix<T, 6, 1> e;
    e << t - T(0.5) * cross + c * phi.cross(cross), phi;
    Eigen::Map<Eigen::Matrix<T, 6, 1>>{residual} = root_.template cast<T>() * e;
    return true;
  }

 private:
  Pose inverse_;
  Matrix6d root_;
};

}  // namespace

ExampleResult SolveLikeCeresExample(const pose_graph::Problem& problem) {
  std::vector<Blocks> blocks;
  for (const Pose& pose : problem.poses) blocks.push_back({pose.translation(), pose.rotation()});
  ceres::Problem ceres_problem;
  auto* manifold = new ceres::EigenQuaternionManifold;  // The problem owns it.
  for (const pose_graph::Edge& edge : problem.edges) {
    Blocks& a = blocks[static_cast<size_t>(edge.a)];
    Blocks& b = blocks[static_cast<size_t>(edge.b)];
    ceres_problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<ExampleError, 6, 3, 4, 3, 4>(new ExampleError(edge)),
        nullptr, a.p.data(), a.q.coeffs().data(), b.p.data(), b.q.coeffs().data());
    ceres_problem.SetManifold(a.q.coeffs().data(), manifold);
    ceres_problem.SetManifold(b.q.coeffs().data(), manifold);
  }
  if (!blocks.empty() && ceres_problem.HasParameterBlock(blocks[0].p.data())) {
    ceres_problem.SetParameterBlockConstant(blocks[0].p.data());
    ceres_problem.SetParameterBlockConstant(blocks[0].q.coeffs().data());
  }
  ceres::Solver::Options options;
  options.max_num_iterations = 200;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  ExampleResult result;
  result.iterations = static_cast<int>(summary.iterations.size()) - 1;
  for (const Blocks& block : blocks) result.poses.emplace_back(block.q, block.p);
  return result;
}

}  // namespace isthmus::bench
