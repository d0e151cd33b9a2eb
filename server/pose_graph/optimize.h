// Poses that agree best with all edges and anchors of a pose graph.
//
// Minimises the sum of the squared errors of problem.h over SE(3) with Ceres (sparse normal
// equations, Levenberg-Marquardt close to Gauss-Newton). Edges marked as doubtful are judged by
// graduated non-convexity with the truncated least-squares cost: Yang, Antonante, Tzoumas, Carlone,
// "Graduated Non-Convexity for Robust Spatial Perception", RA-L 2020, eqs. 12-14 and remark 5. It
// begins without those that contradict sure edges by more than their drift explains (drift_gate.h);
// they are looked at again with the rest. So poses given at the start should be such as sure edges
// give (a robot's odometry), or a former result.
//
// Deterministic for one thread. Thread safe (no shared state).
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "server/pose_graph/problem.h"

namespace isthmus::pose_graph {

struct Options {
  int max_iterations = 100;  // Limit for each least-squares problem; GNC solves several.
  int num_threads = 1;       // Ceres' own; poses may differ in the last digits for more than one.
  double max_seconds = 0;    // Wall time after which the best so far is returned; 0: no limit.
  bool judge = true;         // Doubtful edges and anchors may be discarded (GNC).
  // Begin with the judgement that the problem comes with (Edge::weight, Anchor::weight). If, at the
  // poses that follow from it, none of the kept contradicts and none of the discarded agrees, that
  // is the result; else all are judged as if there were none. Much faster where some are false.
  bool go_on = false;
  // One is discarded in the end when its e^T information e is above this. The default is passed by
  // 1 % of right edges, if their information is honest (chi-square, 6 degrees of freedom).
  double doubt_chi2 = 16.81;
};

struct Result {
  std::vector<Pose> poses;             // T_map_node; those of held nodes are unchanged.
  std::vector<double> edge_weights;    // [0, 1], 0: discarded; 1 for edges not in doubt.
  std::vector<double> anchor_weights;  // The same for anchors.
  double initial_chi2 = 0;             // Sum of e^T information e, everything counted once.
  double final_chi2 = 0;               // The same at `poses`, times the weights found.
  int iterations = 0;                  // Steps taken in all, of all problems solved.
  bool converged = false;              // False: out of iterations or time; poses are usable.
  std::vector<int> held;               // Nodes that were held to fix the gauge, ascending.
  int free_nodes = 0;                  // Nodes that were allowed to move in the last problem.
};

// InvalidArgument, naming the culprit, when an index is out of range, an edge joins a node with
// itself, a number is not finite or an information matrix is not one (SquareRootInformation).
// Internal when the solver gives up; nothing aborts. An empty problem has an empty result.
//
// ChooseGauge (gauge.h) chooses what fixes the gauge. A part of the graph that loses its every tie
// to the rest because all of them are discarded stays near where the search began.
absl::StatusOr<Result> Optimize(const Problem& problem, const Options& options = {});

}  // namespace isthmus::pose_graph
