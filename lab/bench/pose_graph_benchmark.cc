// The cost and the results of optimising pose graphs; see lab/docs/pose_graph.md.
#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <CLI/CLI.hpp>
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "lab/bench/calibration.h"
#include "lab/bench/cpu_clock.h"
#include "lab/bench/pose_graph/graphs.h"
#include "server/pose_graph/g2o.h"
#include "server/pose_graph/optimize.h"
#include "server/pose_graph/problem.h"

namespace isthmus::bench {
namespace {

struct ExampleResult {
  std::vector<Pose> poses;
  int iterations = 0;
};

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

// Position and quaternion as two blocks with Ceres' quaternion manifold, errors and Jacobians by
// automatic differentiation, sparse normal equations, 200 iterations, all else as Ceres has it. The
// first node is held. The error is that of pose_graph::Edge and the square root of its information
// the right way round, so that the sums compare. No edge is discarded.
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

double Chi2Sum(const pose_graph::Problem& problem, const std::vector<Pose>& poses) {
  const pose_graph::Problem now{poses, {}, {}, {}};
  double sum = 0;
  for (const pose_graph::Edge& edge : problem.edges) sum += pose_graph::Chi2(now, edge);
  return sum;
}

std::string Error(const BenchmarkGraph& graph, const std::vector<Pose>& poses) {
  return graph.truth.empty() ? "–" : absl::StrFormat("%.3f", AlignedRmse(poses, graph.truth));
}

void PrintRow(const BenchmarkGraph& graph, const char* how, double chi2,
              const std::vector<Pose>& poses, double ms, double cal_ms, int iterations) {
  absl::PrintF("| %s | %d / %d | %s | %.6g | %s | %.0f | %.2f | %d |\n", graph.name,
               graph.problem.poses.size(), graph.problem.edges.size(), how, chi2,
               Error(graph, poses), ms, ms / cal_ms, iterations);
  std::fflush(stdout);
}

// The least CPU time of a few runs; the result of the last.
template <typename Work>
auto Timed(int repeats, const Work& work, double* ms) {
  CpuClock first;
  auto result = work();
  *ms = first.Ms();
  for (int i = 1; i < repeats; ++i) {
    CpuClock clock;
    result = work();
    *ms = std::min(*ms, clock.Ms());
  }
  return result;
}

bool RunGraph(const BenchmarkGraph& graph, int repeats) {
  const double cal_ms = CalibrationMs();
  const pose_graph::Problem& problem = graph.problem;
  PrintRow(graph, "start", Chi2Sum(problem, problem.poses), problem.poses, 0, cal_ms, 0);
  pose_graph::Options options;
  options.judge = false;
  double ms = 0;
  const auto ours = Timed(
      repeats, [&] { return Optimize(problem, options); }, &ms);
  if (!ours.ok()) {
    absl::FPrintF(stderr, "%s: %s\n", graph.name, std::string(ours.status().message()));
    return false;
  }
  PrintRow(graph, "isthmus", Chi2Sum(problem, ours->poses), ours->poses, ms, cal_ms,
           ours->iterations);
  pose_graph::Problem solved = problem;
  solved.poses = ours->poses;
  const auto again = Timed(
      repeats, [&] { return Optimize(solved, options); }, &ms);
  if (!again.ok()) return false;
  PrintRow(graph, "isthmus, from there", Chi2Sum(problem, again->poses), again->poses, ms, cal_ms,
           again->iterations);
  const auto theirs = Timed(
      1, [&] { return SolveLikeCeresExample(problem); }, &ms);
  PrintRow(graph, "Ceres' example", Chi2Sum(problem, theirs.poses), theirs.poses, ms, cal_ms,
           theirs.iterations);
  return true;
}

bool ReadFile(const std::string& path, BenchmarkGraph* graph) {
  std::ifstream file(path);
  if (!file) {
    absl::FPrintF(stderr, "%s: cannot be opened\n", path);
    return false;
  }
  auto read = pose_graph::ReadG2o(file);
  if (!read.ok()) {
    absl::FPrintF(stderr, "%s: %s\n", path, std::string(read.status().message()));
    return false;
  }
  graph->name = path.substr(path.find_last_of('/') + 1);
  graph->problem = std::move(read->problem);
  return true;
}

constexpr char kHeader[] =
    "| graph | nodes / edges | solver | chi2 | RMSE m | ms | cal | iterations |\n"
    "|---|---|---|---|---|---|---|---|\n";

int Run(const std::vector<std::string>& files, uint64_t seed, int repeats) {
  std::vector<BenchmarkGraph> graphs;
  for (const std::string& path : files) {
    if (!ReadFile(path, &graphs.emplace_back())) return 1;
  }
  if (files.empty()) graphs = {SphereGraph(seed), GarageGraph(seed), CampusGraph(seed)};
  std::fputs(kHeader, stdout);
  for (const BenchmarkGraph& graph : graphs) {
    if (!RunGraph(graph, repeats)) return 1;
  }
  return 0;
}

}  // namespace

}  // namespace isthmus::bench

int main(int argc, char** argv) {
  CLI::App app{"What optimising pose graphs costs and achieves. Without files: graphs made here."};
  std::vector<std::string> files;
  uint64_t seed = 1;
  int repeats = 5;
  app.add_option("files", files, "g2o files of 3-D graphs");
  app.add_option("--seed", seed, "of the graphs made here");
  app.add_option("--repeats", repeats, "runs of which the fastest counts")
      ->check(CLI::Range(1, 100));
  CLI11_PARSE(app, argc, argv);
  return isthmus::bench::Run(files, seed, repeats);
}
