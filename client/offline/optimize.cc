// isthmus optimize: the poses of a g2o file that agree best with its edges, without a server.
#include "server/pose_graph/optimize.h"

#include <algorithm>
#include <chrono>

#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/offline_commands.h"
#include "client/console/pose_graph_file.h"
#include "client/console/say.h"
#include "client/offline/commands.h"
#include "server/pose_graph/chordal.h"
#include "server/pose_graph/own_scale.h"

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
  pose_graph::PublicCosts initial, final;
  bool is_chordal = false;
  double sigma_scale = 1, seconds = 0;
};

void ReportJson(const OptimizeOptions& options, const PoseGraphFile& file, const Summary& summary,
                const pose_graph::Result& result, int64_t discarded) {
  Print({{"file", options.output},
         {"vertices", file.graph.problem.poses.size()},
         {"edges", file.graph.problem.edges.size()},
         {"left_out", file.graph.left_out},
         {"placed_by_edges", file.graph.placed_by_edges},
         {"discarded", discarded},
         {"sigma_scale", summary.sigma_scale},
         {"start", summary.is_chordal ? "chordal" : "file"},
         {"initial_chi2", result.initial_chi2},
         {"final_chi2", result.final_chi2},
         {"initial_g2o_chi2", summary.initial.g2o},
         {"final_g2o_chi2", summary.final.g2o},
         {"initial_se_sync_cost", summary.initial.se_sync},
         {"final_se_sync_cost", summary.final.se_sync},
         {"iterations", result.iterations},
         {"converged", result.converged},
         {"seconds", summary.seconds}});
}

void Report(const OptimizeOptions& options, const PoseGraphFile& file, const Summary& summary,
            const pose_graph::Result& result) {
  const std::vector<double>& weights = result.edge_weights;
  const int64_t discarded =
      std::count_if(weights.begin(), weights.end(), [](double w) { return w < 0.5; });
  if (options.json) return ReportJson(options, file, summary, result, discarded);
  Say("%s: vertices: %d, edges: %d, discarded: %d\n", options.output,
      file.graph.problem.poses.size(), file.graph.problem.edges.size(), discarded);
  if (summary.sigma_scale > 1) {
    Say("edges were judged by sigmas %.3g times as large as the file's, because their errors are "
        "that large\n",
        summary.sigma_scale);
  }
  Say("chi2 %.6g -> %.6g in %d iterations, %.3f s%s%s\n", result.initial_chi2, result.final_chi2,
      result.iterations, summary.seconds, summary.is_chordal ? ", from a chordal start" : "",
      result.converged ? "" : "; not converged");
  Say("as g2o counts: chi2 %.6g -> %.6g; as SE-Sync counts: %.6g -> %.6g\n", summary.initial.g2o,
      summary.final.g2o, summary.initial.se_sync, summary.final.se_sync);
}

// From the poses of the file, or from chordal ones where those agree better. chi2 of the result
// begins with the file's poses all the same.
absl::StatusOr<pose_graph::ScaledResult> Solve(const OptimizeOptions& options,
                                               const pose_graph::Problem& problem,
                                               Summary& summary) {
  pose_graph::Options solver;
  solver.num_threads = options.threads;
  pose_graph::Problem start = problem;
  if (auto chordal = pose_graph::BetterStart(problem, solver.doubt_chi2)) {
    start.poses = *std::move(chordal);
    summary.is_chordal = true;
  }
  auto scaled = pose_graph::OptimizeAtOwnScale(start, solver);
  if (!scaled.ok()) return scaled;
  scaled->result.initial_chi2 = 0;
  for (const pose_graph::Edge& edge : problem.edges) {
    scaled->result.initial_chi2 += pose_graph::Chi2(problem, edge);
  }
  return scaled;
}

int Run(const OptimizeOptions& options) {
  auto file = ReadPoseGraph(options.input);
  if (!file.ok()) return FailInput(file.status());
  SayWhatIsMissing(options.input, file->graph);
  if (options.robust) DoubtAllButOdometry(*file);
  pose_graph::Problem& problem = file->graph.problem;
  const bool is_planar = file->graph.is_planar;
  Summary summary;
  summary.initial =
      pose_graph::CostsOfOthers(problem, std::vector<double>(problem.edges.size(), 1.0), is_planar);
  const auto start = std::chrono::steady_clock::now();
  const auto scaled = Solve(options, problem, summary);
  if (absl::IsInvalidArgument(scaled.status())) return FailInput(scaled.status());
  if (!scaled.ok()) return Fail(kFailed, scaled.status());
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  summary.sigma_scale = scaled->sigma_scale;
  problem.poses = scaled->result.poses;
  summary.final = pose_graph::CostsOfOthers(problem, scaled->result.edge_weights, is_planar);
  const absl::Status written = WritePoseGraph(options.output, *file);
  if (!written.ok()) return Fail(kFailed, written);
  Report(options, *file, summary, scaled->result);
  return kOk;
}

}  // namespace

void AddOptimize(CLI::App& app, Action& action) {
  auto options = std::make_shared<OptimizeOptions>();
  CLI::App* command = AddOfflineCommand(app, "optimize");
  command->add_option("INPUT", options->input, "FILE.g2o: SE3:QUAT or SE2 vertices and edges")
      ->required();
  command->add_option("OUTPUT", options->output, "FILE.g2o for all edges and the poses found")
      ->required();
  command->add_flag("--robust", options->robust,
                    "Discard edges that the others contradict; edges between neighbouring ids "
                    "count as odometry and are kept");
  command->add_option("--threads", options->threads, "That compute")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_flag("--json", options->json, "Summary as JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
