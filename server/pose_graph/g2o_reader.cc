// Reads g2o's text.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <span>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "server/pose_graph/along_edges.h"
#include "server/pose_graph/g2o.h"
#include "server/pose_graph/g2o_information.h"
#include "server/pose_graph/information.h"

namespace isthmus::pose_graph {
namespace {

constexpr char kVertexSe3[] = "VERTEX_SE3:QUAT", kVertexSe2[] = "VERTEX_SE2";
constexpr char kEdgeSe3[] = "EDGE_SE3:QUAT", kEdgeSe2[] = "EDGE_SE2";

struct NamedEdge {
  int64_t a = 0, b = 0;
  Edge edge;
};

using Words = std::vector<absl::string_view>;

// Without a comment at the end.
Words Split(absl::string_view line) {
  Words words = absl::StrSplit(line, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
  const auto comment = std::find_if(words.begin(), words.end(),
                                    [](absl::string_view word) { return word[0] == '#'; });
  words.erase(comment, words.end());
  return words;
}

bool IsTag(absl::string_view word) {
  return absl::ascii_isupper(static_cast<unsigned char>(word[0])) &&
         std::all_of(word.begin(), word.end(), [](char c) {
           return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '_' || c == ':';
         });
}

bool ParseIds(const Words& words, size_t first, size_t count, int64_t* ids) {
  for (size_t i = 0; i < count; ++i) {
    if (!absl::SimpleAtoi(words[first + i], &ids[i])) return false;
  }
  return true;
}

// As many as `numbers` has, finite or not.
bool ParseNumbers(const Words& words, size_t first, std::span<double> numbers) {
  for (size_t i = 0; i < numbers.size(); ++i) {
    if (!absl::SimpleAtod(words[first + i], &numbers[i])) return false;
  }
  return true;
}

// x y z qx qy qz qw, or x y angle.
std::optional<Pose> PoseOf(std::span<const double> v) {
  if (!std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); })) {
    return std::nullopt;
  }
  if (v.size() == 3) return Pose::FromXyzRpy(v[0], v[1], 0, 0, 0, v[2]);
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (!(q.norm() > 1e-6) || !std::isfinite(q.norm())) return std::nullopt;
  return Pose(q, Eigen::Vector3d(v[0], v[1], v[2]));
}

// The upper triangle, row by row.
template <int N>
Eigen::Matrix<double, N, N> Symmetric(std::span<const double> numbers) {
  Eigen::Matrix<double, N, N> matrix;
  size_t next = 0;
  for (int row = 0; row < N; ++row) {
    for (int column = row; column < N; ++column) {
      matrix(row, column) = matrix(column, row) = numbers[next++];
    }
  }
  return matrix;
}

class Reader {
 public:
  explicit Reader(bool only_vertices) : only_vertices_(only_vertices) {}

  absl::Status Read(std::istream& input) {
    std::string text;
    while (std::getline(input, text)) {
      ++line_;
      const Words words = Split(text);
      if (words.empty() || absl::StartsWith(words[0], "PARAMS_")) continue;
      const absl::Status status = ReadLine(words);
      if (!status.ok()) return status;
    }
    if (input.bad()) return absl::UnavailableError("the file cannot be read to its end");
    return absl::OkStatus();
  }

  std::vector<Pose> Poses() const {
    std::vector<Pose> poses;
    for (const auto& [id, pose] : vertices_) poses.push_back(pose);
    return poses;
  }

  absl::StatusOr<G2oGraph> Graph() {
    if (vertices_.empty() && edges_.empty()) {
      return absl::InvalidArgumentError(absl::StrCat("holds no ", kVertexSe3, ", ", kEdgeSe3, ", ",
                                                     kVertexSe2, " or ", kEdgeSe2, " line"));
    }
    G2oGraph graph;
    const std::map<int64_t, int> index = NameNodes(graph);
    for (const NamedEdge& named : edges_) {
      graph.problem.edges.push_back(named.edge);
      graph.problem.edges.back().a = index.at(named.a);
      graph.problem.edges.back().b = index.at(named.b);
    }
    for (const int64_t id : fixed_) {
      const auto node = index.find(id);
      if (node == index.end()) {
        ++left_out_["FIX of another vertex"];
      } else {
        graph.problem.fixed.push_back(node->second);
      }
    }
    graph.is_planar = !has_se3_;
    graph.left_out = std::move(left_out_);
    std::vector<bool> has_pose;
    for (const int64_t id : graph.ids) has_pose.push_back(vertices_.contains(id));
    PlaceAlongEdges(std::move(has_pose), graph.problem);
    return graph;
  }

 private:
  absl::Status Error(absl::string_view what) const {
    return absl::InvalidArgumentError(absl::StrCat("line ", line_, ": ", what));
  }

  absl::Status ReadLine(const Words& words) {
    const absl::string_view tag = words[0];
    if (tag == kVertexSe3)
      return ReadVertex(words, 7, "VERTEX_SE3:QUAT needs: id x y z qx qy qz qw");
    if (tag == kVertexSe2) return ReadVertex(words, 3, "VERTEX_SE2 needs: id x y angle");
    if (only_vertices_) return absl::OkStatus();
    if (tag == kEdgeSe3) {
      return ReadEdge<6>(
          words, 7, "EDGE_SE3:QUAT needs: a b x y z qx qy qz qw and 21 numbers of information");
    }
    if (tag == kEdgeSe2) {
      return ReadEdge<3>(words, 3, "EDGE_SE2 needs: a b x y angle and 6 numbers of information");
    }
    if (tag == "FIX") return ReadFix(words);
    if (!IsTag(tag)) return Error("does not begin with a tag, as VERTEX_SE3:QUAT is one");
    ++left_out_[std::string(tag)];
    return absl::OkStatus();
  }

  absl::Status ReadVertex(const Words& words, size_t numbers, absl::string_view needed) {
    int64_t id = 0;
    std::array<double, 7> values{};
    const std::span<double> pose(values.data(), numbers);
    if (words.size() != 2 + numbers || !ParseIds(words, 1, 1, &id) ||
        !ParseNumbers(words, 2, pose)) {
      return Error(needed);
    }
    const std::optional<Pose> parsed = PoseOf(pose);
    if (!parsed) return Error(needed);
    if (numbers == 7) has_se3_ = true;
    if (!vertices_.emplace(id, *parsed).second) return Error("this vertex is given twice");
    return absl::OkStatus();
  }

  template <int N>
  absl::Status ReadEdge(const Words& words, size_t pose_numbers, absl::string_view needed) {
    std::array<int64_t, 2> ids{};
    std::array<double, 28> values{};
    const size_t numbers = pose_numbers + N * (N + 1) / 2;
    if (words.size() != 3 + numbers || !ParseIds(words, 1, 2, ids.data()) ||
        !ParseNumbers(words, 3, {values.data(), numbers})) {
      return Error(needed);
    }
    const std::optional<Pose> T_a_b = PoseOf({values.data(), pose_numbers});
    if (!T_a_b) return Error(needed);
    if (N == 6) has_se3_ = true;
    const Eigen::Matrix<double, N, N> information =
        Symmetric<N>({values.data() + pose_numbers, numbers - pose_numbers});
    Matrix6d g2o;
    if constexpr (N == 6) g2o = information;
    if constexpr (N == 3) g2o = FromPlanarInformation(information);
    AddEdge({ids[0], ids[1], {0, 0, *T_a_b, g2o}});
    return absl::OkStatus();
  }

  // Adds the edge if its information is of use.
  void AddEdge(NamedEdge named) {
    Matrix6d& information = named.edge.information;
    if (named.a == named.b) {
      ++left_out_["edge from a vertex to itself"];
    } else if (!SquareRootInformation(information).ok()) {
      ++left_out_["edge whose information is indefinite or not finite"];
    } else {
      information = FromG2oInformation(information, named.edge.T_a_b);
      edges_.push_back(named);
    }
  }

  absl::Status ReadFix(const Words& words) {
    std::vector<int64_t> ids(words.size() - 1);
    if (ids.empty() || !ParseIds(words, 1, ids.size(), ids.data())) {
      return Error("FIX needs the ids of vertices");
    }
    fixed_.insert(ids.begin(), ids.end());
    return absl::OkStatus();
  }

  // All that vertices or edges name, ascending; a vertex without a pose is at the origin.
  std::map<int64_t, int> NameNodes(G2oGraph& graph) const {
    std::map<int64_t, int> index;
    for (const auto& [id, pose] : vertices_) index[id] = 0;
    for (const NamedEdge& named : edges_) index[named.a] = index[named.b] = 0;
    for (auto& [id, node] : index) {
      node = static_cast<int>(graph.ids.size());
      graph.ids.push_back(id);
      const auto vertex = vertices_.find(id);
      graph.problem.poses.push_back(vertex == vertices_.end() ? Pose() : vertex->second);
    }
    graph.placed_by_edges = graph.ids.size() - vertices_.size();
    return index;
  }

  const bool only_vertices_;
  int line_ = 0;
  bool has_se3_ = false;
  std::map<int64_t, Pose> vertices_;
  std::vector<NamedEdge> edges_;
  std::set<int64_t> fixed_;
  std::map<std::string, size_t> left_out_;
};

}  // namespace

absl::StatusOr<G2oGraph> ReadG2o(std::istream& input) {
  Reader reader(false);
  const absl::Status status = reader.Read(input);
  if (!status.ok()) return status;
  return reader.Graph();
}

absl::StatusOr<std::vector<Pose>> ReadG2oVertices(std::istream& input) {
  Reader reader(true);
  const absl::Status status = reader.Read(input);
  if (!status.ok()) return status;
  return reader.Poses();
}

}  // namespace isthmus::pose_graph
