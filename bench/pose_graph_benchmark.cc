// What optimising pose graphs costs and achieves; see BENCHMARK.md.
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
#include "server/pose_graph/optimize.h"

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
