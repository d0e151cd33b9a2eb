#include "server/matching/registration/kd_tree.h"

#include <algorithm>
#include <numeric>

#include "server/matching/registration/limits.h"

namespace isthmus::matching {
namespace {

// The axis along which the points spread most.
int WidestAxis(const std::vector<Eigen::Vector3f>& points, const int32_t* begin,
               const int32_t* end) {
  Eigen::Vector3f low = points[*begin], high = low;
  for (const int32_t* i = begin; i != end; ++i) {
    low = low.cwiseMin(points[*i]);
    high = high.cwiseMax(points[*i]);
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  return axis;
}

}  // namespace

// Keeps the k nearest so far in ascending order; insertion is quick for the small k used here.
struct KdTree::KNearestVisitor {
  size_t k;
  float max_distance2;
  std::vector<Neighbor>* found;

  float radius2() const {
    return found->size() < k ? max_distance2 : found->back().squared_distance;
  }
  void Offer(int index, float distance2) {
    if (found->size() == k) found->pop_back();
    const auto place =
        std::upper_bound(found->begin(), found->end(), distance2,
                         [](float d, const Neighbor& n) { return d < n.squared_distance; });
    found->insert(place, {index, distance2});
  }
};

KdTree::KdTree(const std::vector<Eigen::Vector3f>& points) : order_(points.size()) {
  if (points.empty()) return;
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.reserve(2 * points.size() / (kLeafPoints / 2) + 1);
  Build(points, 0, static_cast<int32_t>(points.size()));
  points_.reserve(points.size());
  for (int32_t index : order_) points_.push_back(points[index]);
}

int32_t KdTree::Build(const std::vector<Eigen::Vector3f>& points, int32_t begin, int32_t end) {
  const int32_t index = static_cast<int32_t>(nodes_.size());
  nodes_.emplace_back();
  if (end - begin <= kLeafPoints) {
    nodes_[index] = {-1, 0.0f, begin, end};
    return index;
  }
  const int axis = WidestAxis(points, order_.data() + begin, order_.data() + end);
  const int32_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](int32_t i, int32_t j) { return points[i][axis] < points[j][axis]; });
  const float split = points[order_[middle]][axis];
  const int32_t left = Build(points, begin, middle);
  const int32_t right = Build(points, middle, end);
  nodes_[index] = {axis, split, left, right};
  return index;
}

void KdTree::KNearest(const Eigen::Vector3f& query, int k, float max_distance,
                      std::vector<Neighbor>* neighbors) const {
  neighbors->clear();
  if (nodes_.empty() || k <= 0) return;
  KNearestVisitor visitor{static_cast<size_t>(k), max_distance * max_distance, neighbors};
  Search(0, query, visitor);
}

}  // namespace isthmus::matching
