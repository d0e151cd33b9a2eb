#include "lab/bench/occupancy/octomap_judge.h"

#include <octomap/OcTree.h>

#include <sstream>

#include "lab/bench/cpu_clock.h"

namespace isthmus::bench {
namespace {

void Insert(const Submap& submap, const Pose& T_map_submap, double max_range_m,
            octomap::OcTree* tree) {
  size_t begin = 0;
  for (size_t k = 0; k < submap.keyframes.size(); ++k) {
    octomap::Pointcloud cloud;
    for (; begin < submap.points.size() && submap.points[begin].keyframe <= k; ++begin) {
      const Eigen::Vector3d p =
          T_map_submap * submap.points[begin].Position().cast<double>().eval();
      cloud.push_back(octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()),
                                       static_cast<float>(p.z())));
    }
    const Eigen::Vector3d o = T_map_submap * submap.keyframes[k].T_submap_sensor.translation();
    const octomap::point3d origin(static_cast<float>(o.x()), static_cast<float>(o.y()),
                                  static_cast<float>(o.z()));
    tree->insertPointCloud(cloud, origin, max_range_m, false, true);
  }
}

// Number of voxels that `tree` has occupied, and number of these that `other` has not.
struct Count {
  int64_t occupied = 0, lacking = 0;
};

Count CountOccupied(const octomap::OcTree& tree, const octomap::OcTree& other) {
  Count count;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    if (!tree.isNodeOccupied(*leaf)) continue;
    const octomap::OcTreeKey first = leaf.getIndexKey();
    const int edge = 1 << (tree.getTreeDepth() - leaf.getDepth());
    for (int i = 0; i < edge * edge * edge; ++i) {
      const auto at = [](octomap::key_type key, int by) {
        return static_cast<octomap::key_type>(key + by);
      };
      const octomap::OcTreeNode* node = other.search(octomap::OcTreeKey(
          at(first[0], i % edge), at(first[1], i / edge % edge), at(first[2], i / edge / edge)));
      ++count.occupied;
      count.lacking += node == nullptr || !other.isNodeOccupied(node);
    }
  }
  return count;
}

}  // namespace

OctomapJudgement JudgeByOctomap(const std::vector<PlacedSubmap>& submaps,
                                const SubmapReader& reader,
                                const composition::OccupancyOptions& options,
                                const std::string& file) {
  octomap::OcTree theirs(options.resolution_m), ours(options.resolution_m);
  OctomapJudgement judgement;
  const CpuClock clock;
  for (const PlacedSubmap& placed : submaps) {
    Insert(*reader(placed.submap->id), placed.T_map_submap, options.max_range_m, &theirs);
  }
  judgement.ms = clock.Ms();
  std::istringstream stream(file);
  if (!ours.readBinary(stream)) return judgement;
  const Count expected = CountOccupied(theirs, ours);
  judgement.occupied = expected.occupied;
  judgement.differing = expected.lacking + CountOccupied(ours, theirs).lacking;
  return judgement;
}

}  // namespace isthmus::bench
