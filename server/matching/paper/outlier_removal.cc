#include "server/matching/paper/outlier_removal.h"

#include <pcl/filters/statistical_outlier_removal.h>

#include "server/matching/paper/pcl_cloud.h"

namespace isthmus::matching {

std::vector<ViewedPoint> RemoveOutliers(const std::vector<ViewedPoint>& points,
                                        const OutlierRemovalOptions& options) {
  if (static_cast<int>(points.size()) <= options.neighbors) return points;
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(points.size());
  for (const ViewedPoint& point : points) positions.push_back(point.position);
  pcl::StatisticalOutlierRemoval<pcl::PointXYZ> filter;
  filter.setInputCloud(ToPcl(positions));
  filter.setMeanK(options.neighbors);
  filter.setStddevMulThresh(options.max_deviations);
  pcl::Indices kept_indices;
  filter.filter(kept_indices);
  std::vector<ViewedPoint> kept;
  kept.reserve(kept_indices.size());
  for (int index : kept_indices) kept.push_back(points[index]);
  return kept;
}

}  // namespace isthmus::matching
