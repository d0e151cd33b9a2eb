#include "server/classes/classify.h"

#include <algorithm>

#include "server/classes/features.h"

namespace isthmus::classes {
namespace {

PointLabel LabelOf(const Shares& shares) {
  const auto best = std::max_element(shares.begin(), shares.end());
  const auto likeliest = static_cast<PointClass>(best - shares.begin());
  return {*best < kKnown ? PointClass::kUnknown : likeliest, likeliest, *best};
}

}  // namespace

std::optional<std::vector<PointLabel>> Classify(std::span<const Eigen::Vector3f> points,
                                                std::span<const Eigen::Vector3f> sensors,
                                                const Eigen::Vector3f& up, const Forest& forest,
                                                const std::function<bool(size_t i)>& ends_at) {
  Surroundings surroundings(points, sensors, up);
  std::vector<PointLabel> labels;
  labels.reserve(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    if (ends_at(i)) return std::nullopt;
    labels.push_back(LabelOf(forest.Tell(surroundings.Of(i))));
  }
  return labels;
}

}  // namespace isthmus::classes
