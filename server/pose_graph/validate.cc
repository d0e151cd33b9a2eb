#include "server/pose_graph/validate.h"

#include <cmath>

#include "absl/strings/str_format.h"

namespace isthmus::pose_graph {
namespace {

bool IsNode(const Problem& problem, int node) {
  return node >= 0 && static_cast<size_t>(node) < problem.poses.size();
}

// Farther away doubles hold less than a micrometre, and squares of errors overflow in the end.
bool IsUsable(const Pose& pose) {
  return pose.IsFinite() && pose.translation().cwiseAbs().maxCoeff() < 1e9;
}

absl::Status ValidateEdges(const Problem& problem) {
  for (size_t i = 0; i < problem.edges.size(); ++i) {
    const Edge& edge = problem.edges[i];
    if (!IsNode(problem, edge.a) || !IsNode(problem, edge.b) || edge.a == edge.b) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "edge %d joins nodes %d and %d; they must be two different ones of the %d poses", i,
          edge.a, edge.b, problem.poses.size()));
    }
    if (!IsUsable(edge.T_a_b) || !edge.information.allFinite() || !std::isfinite(edge.weight)) {
      return absl::InvalidArgumentError(
          absl::StrFormat("edge %d has a number that is not finite or a translation of more than "
                          "1e9 m",
                          i));
    }
  }
  return absl::OkStatus();
}

absl::Status ValidateAnchors(const Problem& problem) {
  for (size_t i = 0; i < problem.anchors.size(); ++i) {
    const Anchor& anchor = problem.anchors[i];
    if (!IsNode(problem, anchor.node)) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "anchor %d is of node %d, but there are %d poses", i, anchor.node, problem.poses.size()));
    }
    if (!IsUsable(anchor.T_map_node) || !anchor.information.allFinite()) {
      return absl::InvalidArgumentError(
          absl::StrFormat("anchor %d has a number that is not finite or a translation of more than "
                          "1e9 m",
                          i));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Validate(const Problem& problem, const Options& options) {
  if (options.max_iterations < 1 || options.num_threads < 1 || !(options.max_seconds >= 0) ||
      !(options.doubt_chi2 > 0)) {
    return absl::InvalidArgumentError(
        "options need max_iterations >= 1, num_threads >= 1, max_seconds >= 0 and doubt_chi2 > 0");
  }
  for (size_t i = 0; i < problem.poses.size(); ++i) {
    if (!IsUsable(problem.poses[i])) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "pose %d has a number that is not finite or lies more than 1e9 m away", i));
    }
  }
  for (const int fixed : problem.fixed) {
    if (!IsNode(problem, fixed)) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "fixed node %d does not exist; there are %d poses", fixed, problem.poses.size()));
    }
  }
  absl::Status status = ValidateEdges(problem);
  if (!status.ok()) return status;
  return ValidateAnchors(problem);
}

}  // namespace isthmus::pose_graph
