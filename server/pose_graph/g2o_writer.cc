// Writes g2o's text.
#include <algorithm>
#include <iomanip>

#include "server/pose_graph/g2o.h"
#include "server/pose_graph/g2o_information.h"

namespace isthmus::pose_graph {
namespace {

class Lines {
 public:
  Lines(std::ostream& output, bool is_planar) : output_(output), is_planar_(is_planar) {
    output << std::setprecision(17);
  }

  void Vertex(int64_t id, const Pose& pose) {
    output_ << (is_planar_ ? "VERTEX_SE2 " : "VERTEX_SE3:QUAT ") << id;
    WritePose(pose);
    output_ << '\n';
  }

  void Fix(int64_t id) { output_ << "FIX " << id << '\n'; }

  void Edge(int64_t a, int64_t b, const Pose& T_a_b, const Matrix6d& g2o) {
    output_ << (is_planar_ ? "EDGE_SE2 " : "EDGE_SE3:QUAT ") << a << ' ' << b;
    WritePose(T_a_b);
    if (is_planar_) {
      WriteUpper(ToPlanarInformation(g2o));
    } else {
      WriteUpper(g2o);
    }
    output_ << '\n';
  }

 private:
  void WritePose(const Pose& pose) {
    const Eigen::Vector3d& t = pose.translation();
    const Eigen::Quaterniond& q = pose.rotation();
    if (is_planar_) {
      output_ << ' ' << t.x() << ' ' << t.y() << ' ' << pose.Yaw();
      return;
    }
    for (const double v : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}) output_ << ' ' << v;
  }

  template <typename Matrix>
  void WriteUpper(const Matrix& matrix) {
    for (int row = 0; row < matrix.rows(); ++row) {
      for (int column = row; column < matrix.cols(); ++column)
        output_ << ' ' << matrix(row, column);
    }
  }

  std::ostream& output_;
  const bool is_planar_;
};

// As an edge from a vertex at the origin: its error is R_anchor^T d and half of R_anchor^T phi.
Matrix6d AnchorInformation(const Anchor& anchor) {
  Matrix6d A = Matrix6d::Zero();
  A.topLeftCorner<3, 3>() = anchor.T_map_node.RotationMatrix();
  A.bottomRightCorner<3, 3>() = 2 * anchor.T_map_node.RotationMatrix();
  return A.transpose() * anchor.information * A;
}

bool InRange(const Problem& problem, int node) {
  return node >= 0 && static_cast<size_t>(node) < problem.poses.size();
}

absl::Status Check(const Problem& problem, const std::vector<int64_t>& ids) {
  bool good = ids.empty() || ids.size() == problem.poses.size();
  for (const Edge& edge : problem.edges) {
    good = good && InRange(problem, edge.a) && InRange(problem, edge.b);
  }
  for (const Anchor& anchor : problem.anchors) good = good && InRange(problem, anchor.node);
  for (const int node : problem.fixed) good = good && InRange(problem, node);
  if (good) return absl::OkStatus();
  return absl::InvalidArgumentError("each node needs one id, and edges nodes that exist");
}

}  // namespace

absl::Status WriteG2o(const Problem& problem, const std::vector<int64_t>& ids, std::ostream& output,
                      bool is_planar) {
  const absl::Status status = Check(problem, ids);
  if (!status.ok()) return status;
  const auto id = [&](int node) {
    return ids.empty() ? int64_t{node} : ids[static_cast<size_t>(node)];
  };
  Lines lines(output, is_planar);
  int64_t origin = 0;  // One above all others.
  for (int node = 0; node < static_cast<int>(problem.poses.size()); ++node) {
    lines.Vertex(id(node), problem.poses[static_cast<size_t>(node)]);
    if (!problem.anchors.empty()) origin = std::max(origin, id(node) + 1);
  }
  for (const int node : problem.fixed) lines.Fix(id(node));
  for (const Edge& edge : problem.edges) {
    lines.Edge(id(edge.a), id(edge.b), edge.T_a_b, ToG2oInformation(edge.information, edge.T_a_b));
  }
  if (!problem.anchors.empty()) {
    lines.Vertex(origin, Pose());
    lines.Fix(origin);
  }
  for (const Anchor& anchor : problem.anchors) {
    lines.Edge(origin, id(anchor.node), anchor.T_map_node, AnchorInformation(anchor));
  }
  output.flush();
  return output ? absl::OkStatus() : absl::UnavailableError("the graph could not be written");
}

}  // namespace isthmus::pose_graph
