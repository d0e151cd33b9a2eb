#include "server/matching/paper/fpfh.h"

#include <absl/container/flat_hash_set.h>
#include <pcl/features/fpfh.h>
#include <pcl/search/kdtree.h>

#include "server/matching/paper/pcl_cloud.h"
#include "server/matching/registration/voxel_key.h"

namespace isthmus::matching {
namespace {

// The first point of every voxel; all of them when voxel_m is not positive.
OrientedPoints Thin(const OrientedPoints& points, double voxel_m) {
  if (!(voxel_m > 0)) return points;
  const float inverse_voxel = static_cast<float>(1.0 / voxel_m);
  OrientedPoints thinned;
  absl::flat_hash_set<uint64_t> taken;
  for (size_t i = 0; i < points.positions.size(); ++i) {
    if (!taken.insert(VoxelKey(points.positions[i], inverse_voxel)).second) continue;
    thinned.positions.push_back(points.positions[i]);
    thinned.normals.push_back(points.normals[i]);
  }
  return thinned;
}

}  // namespace

std::vector<FpfhDescriptor> DescribeFpfh(const OrientedPoints& points,
                                         const std::vector<int>& keypoints,
                                         const FpfhOptions& options) {
  if (keypoints.empty()) return {};
  pcl::FPFHEstimation<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33> estimation;
  std::vector<Eigen::Vector3f> centers;
  centers.reserve(keypoints.size());
  for (int index : keypoints) centers.push_back(points.positions[index]);
  const OrientedPoints surface = Thin(points, options.surface_voxel_m);
  estimation.setInputCloud(ToPcl(centers));
  estimation.setSearchSurface(ToPcl(surface.positions));
  estimation.setInputNormals(ToPclNormals(surface.normals));
  estimation.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  estimation.setRadiusSearch(options.radius_m);
  pcl::PointCloud<pcl::FPFHSignature33> signatures;
  estimation.compute(signatures);
  std::vector<FpfhDescriptor> descriptors;
  descriptors.reserve(signatures.size());
  for (const pcl::FPFHSignature33& signature : signatures) {
    const Eigen::Map<const FpfhDescriptor> histogram(signature.histogram);
    descriptors.push_back(histogram.allFinite() ? FpfhDescriptor(histogram)
                                                : FpfhDescriptor(FpfhDescriptor::Zero()));
  }
  return descriptors;
}

}  // namespace isthmus::matching
