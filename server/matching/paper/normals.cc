#include "server/matching/paper/normals.h"

#include <pcl/features/normal_3d.h>
#include <pcl/search/kdtree.h>

#include "server/matching/paper/pcl_cloud.h"

namespace isthmus::matching {

OrientedPoints EstimateNormals(const std::vector<ViewedPoint>& points,
                               const NormalOptions& options) {
  OrientedPoints oriented;
  if (points.empty()) return oriented;
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(points.size());
  for (const ViewedPoint& point : points) positions.push_back(point.position);
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(ToPcl(positions));
  estimation.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  estimation.setRadiusSearch(options.radius_m);
  pcl::PointCloud<pcl::Normal> estimated;
  estimation.compute(estimated);
  for (size_t i = 0; i < points.size(); ++i) {
    Eigen::Vector3f normal = estimated[i].getNormalVector3fMap();
    if (!normal.allFinite()) continue;
    // PCL has turned it to the origin; only the line it lies on is used.
    if (normal.dot(points[i].to_sensor) < 0) normal = -normal;
    oriented.positions.push_back(points[i].position);
    oriented.normals.push_back(normal);
  }
  return oriented;
}

}  // namespace isthmus::matching
