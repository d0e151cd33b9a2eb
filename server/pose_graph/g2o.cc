#include "server/pose_graph/g2o.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>
#include <sstream>
#include <string>

#include "absl/strings/str_cat.h"
#include "core/geometry/se3.h"
#include "server/pose_graph/information.h"

namespace isthmus::pose_graph {
namespace {

// [t; q] of a small twist.
Matrix6d HalfTurns() {
  Vector6d scale;
  scale << 1, 1, 1, 0.5, 0.5, 0.5;
  return scale.asDiagonal();
}

struct NamedEdge {
  int64_t a = 0, b = 0;
  Edge edge;
  int line = 0;
};

class Reader {
 public:
  absl::Status Read(std::istream& input) {
    std::string text;
    while (std::getline(input, text)) {
      ++line_;
      std::istringstream words(text);
      std::string tag;
      if (!(words >> tag) || tag[0] == '#' || tag.rfind("PARAMS_", 0) == 0) continue;
      const absl::Status status = ReadLine(tag, &words);
      if (!status.ok()) return status;
    }
    if (input.bad()) return absl::UnavailableError("the file cannot be read to its end");
    return absl::OkStatus();
  }

  absl::StatusOr<G2oGraph> Graph() const {
    G2oGraph graph;
    std::map<int64_t, int> index;
    for (const auto& [id, pose] : vertices_) {
      index[id] = static_cast<int>(graph.ids.size());
      graph.ids.push_back(id);
      graph.problem.poses.push_back(pose);
    }
    for (const NamedEdge& named : edges_) {
      const auto a = index.find(named.a), b = index.find(named.b);
      if (a == index.end() || b == index.end() || a == b) {
        return Error(named.line, "an edge must join two different vertices of the file");
      }
      graph.problem.edges.push_back(named.edge);
      graph.problem.edges.back().a = a->second;
      graph.problem.edges.back().b = b->second;
    }
    for (const auto& [id, line] : fixed_) {
      const auto node = index.find(id);
      if (node == index.end()) return Error(line, "FIX names a vertex that is not in the file");
      graph.problem.fixed.push_back(node->second);
    }
    return graph;
  }

 private:
  static absl::Status Error(int line, absl::string_view what) {
    return absl::InvalidArgumentError(absl::StrCat("line ", line, ": ", what));
  }

  absl::Status ReadLine(const std::string& tag, std::istringstream* words) {
    if (tag == "VERTEX_SE3:QUAT") return ReadVertex(words);
    if (tag == "EDGE_SE3:QUAT") return ReadEdge(words);
    if (tag == "FIX") return ReadFix(words);
    if (tag.find("_SE2") != std::string::npos) {
      return Error(line_, "this is a planar graph (SE2); only SE3:QUAT graphs can be read");
    }
    return Error(line_, "unknown tag; expected VERTEX_SE3:QUAT, EDGE_SE3:QUAT or FIX");
  }

  // x y z qx qy qz qw
  static bool ReadPose(std::istringstream* words, Pose* pose) {
    double v[7];
    for (double& number : v) {
      if (!(*words >> number) || !std::isfinite(number)) return false;
    }
    const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
    if (!(q.norm() > 1e-6) || !std::isfinite(q.norm())) return false;
    *pose = Pose(q, Eigen::Vector3d(v[0], v[1], v[2]));
    return true;
  }

  static bool AtEnd(std::istringstream* words) {
    std::string more;
    return !(*words >> more) || more[0] == '#';
  }

  absl::Status ReadVertex(std::istringstream* words) {
    int64_t id = 0;
    Pose pose;
    if (!(*words >> id) || !ReadPose(words, &pose) || !AtEnd(words)) {
      return Error(line_, "VERTEX_SE3:QUAT needs: id x y z qx qy qz qw");
    }
    if (!vertices_.emplace(id, pose).second) return Error(line_, "this vertex is given twice");
    return absl::OkStatus();
  }

  absl::Status ReadEdge(std::istringstream* words) {
    NamedEdge named;
    named.line = line_;
    bool complete =
        static_cast<bool>(*words >> named.a >> named.b) && ReadPose(words, &named.edge.T_a_b);
    Matrix6d g2o = Matrix6d::Zero();
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) {
        complete = complete && static_cast<bool>(*words >> g2o(row, column));
        g2o(column, row) = g2o(row, column);
      }
    }
    if (!complete || !AtEnd(words)) {
      return Error(line_,
                   "EDGE_SE3:QUAT needs: a b x y z qx qy qz qw and 21 numbers of information");
    }
    const auto root = SquareRootInformation(g2o);
    if (!root.ok()) return Error(line_, root.status().message());
    named.edge.information = FromG2oInformation(g2o, named.edge.T_a_b);
    edges_.push_back(named);
    return absl::OkStatus();
  }

  absl::Status ReadFix(std::istringstream* words) {
    int64_t id = 0;
    if (!(*words >> id)) return Error(line_, "FIX needs the ids of vertices");
    do {
      fixed_.emplace(id, line_);
    } while (*words >> id);
    return words->eof() ? absl::OkStatus() : Error(line_, "FIX needs the ids of vertices");
  }

  int line_ = 0;
  std::map<int64_t, Pose> vertices_;
  std::vector<NamedEdge> edges_;
  std::map<int64_t, int> fixed_;  // With the line that says so.
};

void WritePose(const Pose& pose, std::ostream& output) {
  const Eigen::Vector3d& t = pose.translation();
  const Eigen::Quaterniond& q = pose.rotation();
  for (const double v : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}) output << ' ' << v;
}

void WriteEdge(int64_t a, int64_t b, const Pose& T_a_b, const Matrix6d& g2o, std::ostream& output) {
  output << "EDGE_SE3:QUAT " << a << ' ' << b;
  WritePose(T_a_b, output);
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) output << ' ' << g2o(row, column);
  }
  output << '\n';
}

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

Matrix6d ToG2oInformation(const Matrix6d& information, const Pose& T_a_b) {
  // Our twist is Ad(M) times the one on the right, which is [t; 2 q].
  const Matrix6d A = Adjoint(T_a_b) * HalfTurns().inverse();
  return A.transpose() * information * A;
}

Matrix6d FromG2oInformation(const Matrix6d& g2o, const Pose& T_a_b) {
  const Matrix6d A = HalfTurns() * Adjoint(T_a_b.Inverse());
  return A.transpose() * g2o * A;
}

absl::StatusOr<G2oGraph> ReadG2o(std::istream& input) {
  Reader reader;
  const absl::Status status = reader.Read(input);
  if (!status.ok()) return status;
  return reader.Graph();
}

absl::Status WriteG2o(const Problem& problem, const std::vector<int64_t>& ids,
                      std::ostream& output) {
  const absl::Status status = Check(problem, ids);
  if (!status.ok()) return status;
  const auto id = [&](int node) {
    return ids.empty() ? int64_t{node} : ids[static_cast<size_t>(node)];
  };
  output << std::setprecision(17);
  int64_t origin = 0;  // One above all others.
  for (int node = 0; node < static_cast<int>(problem.poses.size()); ++node) {
    output << "VERTEX_SE3:QUAT " << id(node);
    WritePose(problem.poses[static_cast<size_t>(node)], output);
    output << '\n';
    origin = std::max(origin, id(node) + 1);
  }
  for (const int node : problem.fixed) output << "FIX " << id(node) << '\n';
  for (const Edge& edge : problem.edges) {
    WriteEdge(id(edge.a), id(edge.b), edge.T_a_b, ToG2oInformation(edge.information, edge.T_a_b),
              output);
  }
  if (!problem.anchors.empty()) {
    output << "VERTEX_SE3:QUAT " << origin << " 0 0 0 0 0 0 1\nFIX " << origin << '\n';
  }
  for (const Anchor& anchor : problem.anchors) {
    WriteEdge(origin, id(anchor.node), anchor.T_map_node, AnchorInformation(anchor), output);
  }
  output.flush();
  return output ? absl::OkStatus() : absl::UnavailableError("the graph could not be written");
}

}  // namespace isthmus::pose_graph
