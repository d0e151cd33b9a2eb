// The cost of placing submaps, and the effect of false loop closures; see
// lab/docs/placement.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "lab/bench/calibration.h"
#include "lab/bench/cpu_clock.h"
#include "lab/bench/pose_graph/graphs.h"
#include "server/placement/placer.h"

namespace isthmus::bench {
namespace {

using placement::Outcome;
using placement::Placer;
using placement::PlacerOptions;
using Placements = std::vector<Placement>;

const SessionId kSession("robot-1");

// A graph of one robot as the records of a server that has gone through it.
placement::Input MakeInput(const BenchmarkGraph& graph) {
  placement::Input input;
  placement::Session session;
  session.tree.session = session.tree.reference = kSession;
  for (const Pose& pose : graph.problem.poses) {
    placement::Node node;
    node.index = static_cast<uint32_t>(session.nodes.size());
    node.T_odom_submap = pose;
    session.nodes.push_back(node);
  }
  input.sessions.push_back(session);
  for (const pose_graph::Edge& edge : graph.problem.edges) {
    if (!edge.may_be_wrong) continue;
    LoopClosure loop;
    loop.id = input.loops.size() + 1;
    loop.session = kSession;
    loop.submap_a = static_cast<uint32_t>(edge.a);
    loop.submap_b = static_cast<uint32_t>(edge.b);
    loop.T_a_b = edge.T_a_b;
    loop.edges = {{loop.submap_a, loop.submap_b, edge.T_a_b, edge.information}};
    input.loops.push_back(loop);
  }
  return input;
}

// The server's options for odometry that drifts as the graph's does.
PlacerOptions OptionsFor(const BenchmarkGraph& graph) {
  PlacerOptions options;
  const Matrix6d& information = graph.problem.edges.front().information;
  options.drift = {1 / std::sqrt(information(0, 0)), 0, 1 / std::sqrt(information(5, 5)), 0, 0};
  return options;
}

std::vector<Pose> PosesOf(const Outcome& outcome) {
  std::vector<Pose> poses;
  for (const SubmapPose& submap : outcome.placements.front().submaps) {
    poses.push_back(submap.T_map_submap);
  }
  return poses;
}

double Farthest(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  double farthest = 0;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    farthest = std::max(farthest, (a[i].translation() - b[i].translation()).norm());
  }
  return farthest;
}

struct Costs {
  std::vector<double> ms;
  std::vector<double> gap_m;  // From placing everything anew.

  void Print(const char* what, double cal_ms) {
    for (auto* v : {&ms, &gap_m}) std::sort(v->begin(), v->end());
    absl::PrintF("| %s | %d | %.1f / %.1f | %.3f / %.3f |", what, ms.size(), ms[ms.size() / 2],
                 ms.back(), ms[ms.size() / 2] / cal_ms, ms.back() / cal_ms);
    if (gap_m.empty()) {
      std::puts(" – |");
    } else {
      absl::PrintF(" %.4f / %.4f |\n", gap_m[gap_m.size() / 2], gap_m.back());
    }
    std::fflush(stdout);
  }
};

class Trials {
 public:
  Trials(const BenchmarkGraph& graph, int count)
      : options_(OptionsFor(graph)), count_(count), input_(MakeInput(graph)) {}

  bool Run() {
    const double cal_ms = CalibrationMs();
    Costs first, closure, submap, undo, whole;
    for (int k = 0; k < count_; ++k) {
      if (!RunOne(k, options_, &first, &closure, &submap, &undo)) return false;
    }
    PlacerOptions wholly = options_;
    wholly.whole_up_to = input_.sessions[0].nodes.size();
    for (int k = 0; k < count_; ++k) {
      Costs others;
      if (!RunOne(k, wholly, &others, &whole, &others, &others)) return false;
    }
    first.Print("the whole, from odometry", cal_ms);
    submap.Print("a new submap", cal_ms);
    closure.Print("a new closure", cal_ms);
    whole.Print("a new closure, the whole", cal_ms);
    undo.Print("a closure taken back", cal_ms);
    return true;
  }

 private:
  bool Place(Placer* placer, const placement::Input& input, Placements* placements, Costs* costs) {
    CpuClock clock;
    Outcome outcome = placer->Place(input, *placements);
    if (costs != nullptr) costs->ms.push_back(clock.Ms());
    if (!outcome.trouble.empty()) absl::FPrintF(stderr, "%s\n", outcome.trouble);
    *placements = outcome.placements;
    last_ = PosesOf(outcome);
    return outcome.trouble.empty();
  }

  // Without the last submap and one closure; then with the submap, with the closure, without it.
  bool RunOne(int k, const PlacerOptions& options, Costs* first, Costs* closure, Costs* submap,
              Costs* undo) {
    placement::Input input = input_;
    const placement::Node node = input.sessions[0].nodes.back();
    input.sessions[0].nodes.pop_back();
    const size_t pick = (static_cast<size_t>(k) * 977) % input.loops.size();
    const LoopClosure loop = input.loops[pick];
    input.loops.erase(input.loops.begin() + static_cast<std::ptrdiff_t>(pick));
    // The last submap is to close none.
    std::erase_if(input.loops, [&](const LoopClosure& l) { return l.submap_b == node.index; });
    Placer placer(options);
    Placements placements;
    if (!Place(&placer, input, &placements, first)) return false;
    const std::vector<Pose> before = last_;
    input.sessions[0].nodes.push_back(node);
    if (!Place(&placer, input, &placements, submap)) return false;
    input.loops.push_back(loop);
    if (!Place(&placer, input, &placements, closure)) return false;
    const std::vector<Pose> with = last_;
    Placer anew(options_);
    Placements none;
    if (!Place(&anew, input, &none, nullptr)) return false;
    closure->gap_m.push_back(Farthest(with, last_));
    input.loops.pop_back();
    if (!Place(&placer, input, &placements, undo)) return false;
    undo->gap_m.push_back(Farthest(before, last_));
    return true;
  }

  const PlacerOptions options_;
  const int count_;
  const placement::Input input_;
  std::vector<Pose> last_;
};

bool RunFalse(BenchmarkGraph graph, double share) {
  const double cal_ms = CalibrationMs();
  double errors[2] = {};
  for (const int with : {0, 1}) {
    const size_t right = MakeInput(graph).loops.size();
    if (with == 1) AddFalseClosures(share, 5, &graph);
    const placement::Input input = MakeInput(graph);
    Placer placer(OptionsFor(graph));
    CpuClock clock;
    const Outcome outcome = placer.Place(input, {});
    const double ms = clock.Ms();
    if (!outcome.trouble.empty()) return false;
    int kept = 0, lost = 0;
    for (const auto& [id, edges] : outcome.edge_status.loops) {
      if (id > right && edges[0]) ++kept;
      if (id <= right && !edges[0]) ++lost;
    }
    errors[with] = AlignedRmse(PosesOf(outcome), graph.truth);
    absl::PrintF("| %s | %d / %d | %d | %d | %d | %.3f | %.2f | %.0f | %.2f |\n", graph.name,
                 outcome.nodes, outcome.edges, with == 1 ? input.loops.size() - right : 0, kept,
                 lost, errors[with], errors[with] / errors[0], ms, ms / cal_ms);
    std::fflush(stdout);
  }
  return true;
}

int Run(uint64_t seed, int count) {
  const BenchmarkGraph campus = CampusGraph(seed);
  absl::PrintF("%d submaps, %d edges\n\n", campus.problem.poses.size(),
               campus.problem.edges.size());
  std::puts(
      "| placing | trials | ms, median / most | cal | farthest from all anew (taken back: from "
      "before), m |\n|---|---|---|---|---|");
  if (!Trials(campus, count).Run()) return 1;
  std::puts(
      "\n| graph | nodes / edges | false | false kept | right lost | RMSE m | ratio | ms | cal |\n"
      "|---|---|---|---|---|---|---|---|---|");
  for (const BenchmarkGraph& graph : {GarageGraph(seed), campus}) {
    if (!RunFalse(graph, 0.3)) return 1;
  }
  return 0;
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) {
  CLI::App app{"What placing submaps costs, and what false loop closures do to it."};
  uint64_t seed = 1;
  int count = 20;
  app.add_option("--seed", seed, "of the graphs");
  app.add_option("--trials", count, "closures to try")->check(CLI::Range(1, 1000));
  CLI11_PARSE(app, argc, argv);
  return isthmus::bench::Run(seed, count);
}
