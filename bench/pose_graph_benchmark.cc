// The cost and the results of optimising pose graphs; see BENCHMARK.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "bench/calibration.h"
#include "bench/cpu_clock.h"
#include "bench/pose_graph/ceres_example.h"
#include "bench/pose_graph/graphs.h"
#include "server/pose_graph/g2o.h"
#include "server/pose_graph/optimize_around.h"

namespace isthmus::bench {
namespace {

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

bool RunGraph(const BenchmarkGraph& graph, int repeats, bool example) {
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
  if (!example) return true;
  const auto theirs = Timed(
      1, [&] { return SolveLikeCeresExample(problem); }, &ms);
  PrintRow(graph, "Ceres' example", Chi2Sum(problem, theirs.poses), theirs.poses, ms, cal_ms,
           theirs.iterations);
  return true;
}

// Closures in doubt, without and with false ones.
bool RunFalse(BenchmarkGraph graph, double share) {
  const double cal_ms = CalibrationMs();
  double errors[2] = {};
  for (const int with : {0, 1}) {
    const size_t right = graph.problem.edges.size();
    if (with == 1) AddFalseClosures(share, 5, &graph);
    double ms = 0;
    const auto result = Timed(
        1, [&] { return Optimize(graph.problem); }, &ms);
    if (!result.ok()) return false;
    const auto kept =
        std::count_if(result->edge_weights.begin() + static_cast<std::ptrdiff_t>(right),
                      result->edge_weights.end(), [](double weight) { return weight > 0.5; });
    const auto lost =
        std::count_if(result->edge_weights.begin(),
                      result->edge_weights.begin() + static_cast<std::ptrdiff_t>(right),
                      [](double weight) { return weight < 0.5; });
    errors[with] = AlignedRmse(result->poses, graph.truth);
    absl::PrintF("| %s | %d | %d | %d | %d | %.3f | %.2f | %.0f | %.2f |\n", graph.name,
                 graph.problem.edges.size(), graph.problem.edges.size() - right, kept, lost,
                 errors[with], errors[with] / errors[0], ms, ms / cal_ms);
    std::fflush(stdout);
  }
  return true;
}

// Takes closures out one by one, solves, and gives them back as new ones.
bool RunNewClosures(const BenchmarkGraph& graph, int closures) {
  const double cal_ms = CalibrationMs();
  std::vector<double> around_ms, full_ms, gap_m;
  int most_free = 0;
  const size_t odometry = graph.problem.poses.size() - 1;
  for (int k = 0; k < closures; ++k) {
    pose_graph::Problem problem = graph.problem;
    for (pose_graph::Edge& edge : problem.edges) edge.may_be_wrong = false;
    const size_t pick =
        odometry + (static_cast<size_t>(k) * 977) % (problem.edges.size() - odometry);
    std::swap(problem.edges[pick], problem.edges.back());
    const pose_graph::Edge closure = problem.edges.back();
    problem.edges.pop_back();
    const auto before = Optimize(problem);
    if (!before.ok()) return false;
    problem.poses = before->poses;
    problem.edges.push_back(closure);
    double ms = 0;
    const int last = static_cast<int>(problem.edges.size()) - 1;
    const auto around = Timed(
        3, [&] { return OptimizeAround(problem, {last}); }, &ms);
    around_ms.push_back(ms);
    const auto full = Timed(
        1, [&] { return Optimize(problem); }, &ms);
    full_ms.push_back(ms);
    if (!around.ok() || !full.ok()) return false;
    most_free = std::max(most_free, around->free_nodes);
    double gap = 0;
    for (size_t i = 0; i < problem.poses.size(); ++i) {
      gap = std::max(gap, (around->poses[i].translation() - full->poses[i].translation()).norm());
    }
    gap_m.push_back(gap);
  }
  for (auto* v : {&around_ms, &full_ms, &gap_m}) std::sort(v->begin(), v->end());
  const size_t middle = around_ms.size() / 2;
  absl::PrintF("| %s | %d | %.1f / %.1f | %.3f / %.3f | %.0f / %.0f | %d | %.3f / %.3f |\n",
               graph.name, closures, around_ms[middle], around_ms.back(),
               around_ms[middle] / cal_ms, around_ms.back() / cal_ms, full_ms[middle],
               full_ms.back(), most_free, gap_m[middle], gap_m.back());
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

int Run(const std::vector<std::string>& files, uint64_t seed, int repeats, int closures) {
  std::vector<BenchmarkGraph> graphs;
  for (const std::string& path : files) {
    if (!ReadFile(path, &graphs.emplace_back())) return 1;
  }
  if (files.empty()) graphs = {SphereGraph(seed), GarageGraph(seed), CampusGraph(seed)};
  std::fputs(kHeader, stdout);
  for (const BenchmarkGraph& graph : graphs) {
    if (!RunGraph(graph, repeats, true)) return 1;
  }
  if (!files.empty()) return 0;
  std::puts(
      "\n| graph | edges | false | false kept | right lost | RMSE m | ratio | ms | cal |\n"
      "|---|---|---|---|---|---|---|---|---|");
  for (const BenchmarkGraph& graph : {GarageGraph(seed), CampusGraph(seed)}) {
    if (!RunFalse(graph, 0.3)) return 1;
  }
  std::puts(
      "\n| graph | new closures | ms, median / most | cal | all anew, ms | nodes free | farthest "
      "from all anew, m |\n|---|---|---|---|---|---|---|");
  return RunNewClosures(CampusGraph(seed), closures) ? 0 : 1;
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) {
  CLI::App app{"What optimising pose graphs costs and achieves. Without files: graphs made here."};
  std::vector<std::string> files;
  uint64_t seed = 1;
  int repeats = 5, closures = 20;
  app.add_option("files", files, "g2o files of 3-D graphs");
  app.add_option("--seed", seed, "of the graphs made here");
  app.add_option("--repeats", repeats, "runs of which the fastest counts")
      ->check(CLI::Range(1, 100));
  app.add_option("--closures", closures, "new closures to try")->check(CLI::Range(1, 1000));
  CLI11_PARSE(app, argc, argv);
  return isthmus::bench::Run(files, seed, repeats, closures);
}
