// isthmus optimize: the poses of a g2o file that agree best with its edges, without a server.
#include "server/pose_graph/optimize.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <chrono>

#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/offline_commands.h"
#include "client/console/pose_graph_file.h"
#include "client/offline/commands.h"

namespace isthmus::cli {
namespace {

struct OptimizeOptions {
  std::string input, output;
  bool robust = false, json = false;
  int threads = 1;
};

// Odometry is sure: edges between neighbours in order of id, of one session where the file says of
// which they are. All others are doubted.
void DoubtAllButOdometry(PoseGraphFile& file) {
  const auto session = [&file](int node) {
    const auto found = file.names.find(file.graph.ids[static_cast<size_t>(node)]);
    return found == file.names.end() ? SessionId() : found->second.session;
  };
  for (pose_graph::Edge& edge : file.graph.problem.edges) {
    edge.may_be_wrong = std::abs(edge.a - edge.b) != 1 || session(edge.a) != session(edge.b);
  }
}

struct Summary {
  size_t vertices = 0, edges = 0;
  int64_t discarded = 0;
  double seconds = 0;
};

void Report(const OptimizeOptions& options, const Summary& summary,
            const pose_graph::Result& result) {
  if (options.json) {
    Print({{"file", options.output},
           {"vertices", summary.vertices},
           {"edges", summary.edges},
           {"discarded", summary.discarded},
           {"initial_chi2", result.initial_chi2},
           {"final_chi2", result.final_chi2},
           {"iterations", result.iterations},
           {"converged", result.converged},
           {"seconds", summary.seconds}});
    return;
  }
  absl::PrintF("%s: vertices: %d, edges: %d, discarded: %d\n", options.output, summary.vertices,
               summary.edges, summary.discarded);
  absl::PrintF("chi2 %.6g -> %.6g in %d iterations, %.3f s%s\n", result.initial_chi2,
               result.final_chi2, result.iterations, summary.seconds,
               result.converged ? "" : "; not converged");
}

int Run(const OptimizeOptions& options) {
  auto file = ReadPoseGraph(options.input);
  if (!file.ok()) return FailInput(file.status());
  if (options.robust) DoubtAllButOdometry(*file);
  pose_graph::Problem& problem = file->graph.problem;
  pose_graph::Options solver;
  solver.num_threads = options.threads;
  const auto start = std::chrono::steady_clock::now();
  const auto result = pose_graph::Optimize(problem, solver);
  if (absl::IsInvalidArgument(result.status())) return FailInput(result.status());
  if (!result.ok()) return Fail(kFailed, result.status());
  Summary summary{problem.poses.size(), problem.edges.size(), 0, 0};
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const std::vector<double>& weights = result->edge_weights;
  summary.discarded =
      std::count_if(weights.begin(), weights.end(), [](double w) { return w < 0.5; });
  problem.poses = result->poses;
  const absl::Status written = WritePoseGraph(options.output, *file);
  if (!written.ok()) return Fail(kFailed, written);
  Report(options, summary, *result);
  return kOk;
}

}  // namespace

void AddOptimize(CLI::App& app, Action& action) {
  auto options = std::make_shared<OptimizeOptions>();
  CLI::App* command = AddOfflineCommand(app, "optimize");
  command->add_option("INPUT", options->input, "FILE.g2o, VERTEX_SE3:QUAT and EDGE_SE3:QUAT")
      ->required();
  command->add_option("OUTPUT", options->output, "FILE.g2o: all edges, the poses found")
      ->required();
  command->add_flag("--robust", options->robust,
                    "Discard edges that the rest contradicts; those between neighbouring ids are "
                    "taken for odometry and kept");
  command->add_option("--threads", options->threads, "That compute")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_flag("--json", options->json, "Summary as JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
