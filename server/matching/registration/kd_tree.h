// A static k-d tree over points in space. Points of a leaf lie side by side in memory, which makes
// it several times faster than trees of pointers on maps of some ten thousand points.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace isthmus::matching {

// Immutable after construction; safe to search from many threads. Results do not depend on anything
// but the points and their order.
class KdTree {
 public:
  struct Neighbor {
    int index = -1;  // Into the points given; -1 when none was near enough.
    float squared_distance = 0;
  };

  KdTree() = default;
  // All points must be finite. Fewer than 2^31.
  explicit KdTree(const std::vector<Eigen::Vector3f>& points);

  bool empty() const { return points_.empty(); }
  size_t size() const { return points_.size(); }

  // The nearest point strictly within `max_distance` that `accept(index)` says yes to; index -1
  // when there is none.
  template <typename Accept>
  Neighbor NearestIf(const Eigen::Vector3f& query, float max_distance, const Accept& accept) const {
    NearestVisitor<Accept> visitor{{-1, max_distance * max_distance}, accept};
    if (!nodes_.empty()) Search(0, query, visitor);
    return visitor.best;
  }
  Neighbor Nearest(const Eigen::Vector3f& query, float max_distance) const {
    return NearestIf(query, max_distance, [](int) { return true; });
  }

  // The at most k nearest points strictly within `max_distance`, nearest first, in `neighbors`,
  // whose former content is lost.
  void KNearest(const Eigen::Vector3f& query, int k, float max_distance,
                std::vector<Neighbor>* neighbors) const;

 private:
  struct Node {
    int32_t axis = -1;  // -1: a leaf.
    float split = 0;
    int32_t left = 0, right = 0;  // Child nodes, or the range of points of a leaf.
  };
  template <typename Accept>
  struct NearestVisitor {
    Neighbor best;
    const Accept& accept;
    float radius2() const { return best.squared_distance; }
    void Offer(int index, float distance2) {
      if (accept(index)) best = {index, distance2};
    }
  };
  struct KNearestVisitor;

  int32_t Build(const std::vector<Eigen::Vector3f>& points, int32_t begin, int32_t end);

  // Offers every point nearer than visitor.radius2(), nearer half first.
  template <typename Visitor>
  void Search(int32_t node_index, const Eigen::Vector3f& query, Visitor& visitor) const {
    const Node& node = nodes_[node_index];
    if (node.axis < 0) {
      for (int32_t i = node.left; i < node.right; ++i) {
        const float distance2 = (points_[i] - query).squaredNorm();
        if (distance2 < visitor.radius2()) visitor.Offer(order_[i], distance2);
      }
      return;
    }
    const float offset = query[node.axis] - node.split;
    Search(offset < 0 ? node.left : node.right, query, visitor);
    if (offset * offset < visitor.radius2()) {
      Search(offset < 0 ? node.right : node.left, query, visitor);
    }
  }

  std::vector<Node> nodes_;              // The root first.
  std::vector<Eigen::Vector3f> points_;  // In the order of the leaves.
  std::vector<int32_t> order_;           // Index as given, for each of points_.
};

}  // namespace isthmus::matching
