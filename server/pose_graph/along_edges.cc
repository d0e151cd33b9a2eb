#include "server/pose_graph/along_edges.h"

#include <cstdlib>
#include <deque>

namespace isthmus::pose_graph {
namespace {

class Placer {
 public:
  Placer(std::vector<bool> has_pose, Problem& problem)
      : has_pose_(std::move(has_pose)), problem_(problem), edges_(problem.poses.size()) {
    for (const Edge& edge : problem.edges) {
      edges_[static_cast<size_t>(edge.a)].push_back(&edge);
      edges_[static_cast<size_t>(edge.b)].push_back(&edge);
    }
  }

  void Run() {
    for (size_t i = 0; i < has_pose_.size(); ++i) {
      if (has_pose_[i]) Open(i);
    }
    Spread();
    for (size_t i = 0; i < has_pose_.size(); ++i) {
      if (has_pose_[i]) continue;
      Place(i, Pose());
      Spread();
    }
  }

 private:
  struct Step {
    size_t from = 0, to = 0;
    const Edge* edge = nullptr;
  };

  void Place(size_t node, const Pose& pose) {
    problem_.poses[node] = pose;
    has_pose_[node] = true;
    Open(node);
  }

  void Open(size_t node) {
    for (const Edge* edge : edges_[node]) {
      const auto a = static_cast<size_t>(edge->a), b = static_cast<size_t>(edge->b);
      const Step step{node, a == node ? b : a, edge};
      if (has_pose_[step.to]) continue;
      if (std::abs(edge->a - edge->b) == 1) {
        open_.push_front(step);
      } else {
        open_.push_back(step);
      }
    }
  }

  void Spread() {
    while (!open_.empty()) {
      const Step step = open_.front();
      open_.pop_front();
      if (has_pose_[step.to]) continue;
      const bool forward = static_cast<size_t>(step.edge->a) == step.from;
      const Pose T_from_to = forward ? step.edge->T_a_b : step.edge->T_a_b.Inverse();
      Place(step.to, problem_.poses[step.from] * T_from_to);
    }
  }

  std::vector<bool> has_pose_;
  Problem& problem_;
  std::vector<std::vector<const Edge*>> edges_;  // By node.
  std::deque<Step> open_;
};

}  // namespace

void PlaceAlongEdges(std::vector<bool> has_pose, Problem& problem) {
  Placer(std::move(has_pose), problem).Run();
}

}  // namespace isthmus::pose_graph
