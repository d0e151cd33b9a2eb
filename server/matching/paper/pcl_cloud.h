// Conversion between our points and PCL's. For .cc files only: headers of this folder keep PCL out.
#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Core>
#include <vector>

namespace isthmus::matching {

inline pcl::PointCloud<pcl::PointXYZ>::Ptr ToPcl(const std::vector<Eigen::Vector3f>& points) {
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  cloud->reserve(points.size());
  for (const Eigen::Vector3f& p : points) cloud->push_back(pcl::PointXYZ(p.x(), p.y(), p.z()));
  return cloud;
}

inline pcl::PointCloud<pcl::Normal>::Ptr ToPclNormals(const std::vector<Eigen::Vector3f>& normals) {
  pcl::PointCloud<pcl::Normal>::Ptr cloud(new pcl::PointCloud<pcl::Normal>);
  cloud->reserve(normals.size());
  for (const Eigen::Vector3f& n : normals) cloud->push_back(pcl::Normal(n.x(), n.y(), n.z()));
  return cloud;
}

}  // namespace isthmus::matching
