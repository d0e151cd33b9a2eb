#include "server/matching/paper/harris.h"

#include <pcl/keypoints/harris_3d.h>

#include <algorithm>
#include <utility>

#include "server/matching/paper/pcl_cloud.h"

namespace isthmus::matching {

std::vector<int> DetectHarrisKeypoints(const OrientedPoints& points, const HarrisOptions& options) {
  if (points.positions.empty()) return {};
  using Harris = pcl::HarrisKeypoint3D<pcl::PointXYZ, pcl::PointXYZI>;
  Harris harris(Harris::HARRIS, static_cast<float>(options.radius_m),
                static_cast<float>(options.threshold));
  harris.setInputCloud(ToPcl(points.positions));
  harris.setNormals(ToPclNormals(points.normals));
  harris.setNonMaxSupression(true);
  harris.setRefine(false);
  harris.setNumberOfThreads(1);  // More would let chance decide the order of the key points.
  pcl::PointCloud<pcl::PointXYZI> responses;
  harris.compute(responses);
  std::vector<std::pair<float, int>> ranked;
  for (size_t i = 0; i < responses.size(); ++i) {
    ranked.emplace_back(-responses[i].intensity, harris.getKeypointsIndices()->indices[i]);
  }
  std::sort(ranked.begin(), ranked.end());
  ranked.resize(std::min(ranked.size(), static_cast<size_t>(std::max(options.max_keypoints, 0))));
  std::vector<int> keypoints;
  for (const auto& [response, index] : ranked) keypoints.push_back(index);
  std::sort(keypoints.begin(), keypoints.end());
  return keypoints;
}

}  // namespace isthmus::matching
