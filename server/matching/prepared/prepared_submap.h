// One submap with everything the matcher needs of it, made once whatever it is matched against.
#pragma once

#include <cstddef>
#include <memory>
#include <stop_token>
#include <vector>

#include "core/geometry/range_image.h"
#include "core/map/submap.h"
#include "server/matching/registration/kd_tree.h"
#include "server/matching/registration/surface.h"

namespace isthmus::matching {

// Everything is in the submap frame, so nothing changes when the submap is placed anew. Immutable;
// safe to read from many threads. Holds on to the submap.
class PreparedSubmap {
 public:
  explicit PreparedSubmap(const std::shared_ptr<const Submap>& submap)
      : PreparedSubmap(submap, *submap) {}
  // Holds on to the outline only: to the submap without its points, which are those of `whole`.
  // Once stopped it is of no use.
  PreparedSubmap(std::shared_ptr<const Submap> outline, const Submap& whole,
                 const std::stop_token& stop = {});

  // The measurements of keyframes with points that are a metre or a turn apart, or farther if there
  // would be more than kMaxViews of them (limits.h).
  struct View {
    Pose T_submap_sensor;
    RangeImage image;
  };

  // From parts that were kept, as the accessors below give them.
  PreparedSubmap(std::shared_ptr<const Submap> submap, double voxel_m,
                 std::vector<SurfacePoint> surface, std::vector<View> views);

  const Submap& submap() const { return *submap_; }
  const std::vector<SurfacePoint>& surface() const { return surface_; }
  // Between points of the surface: 0.25 m, 0.5 m where it looks like outdoors.
  double voxel_m() const { return voxel_m_; }
  const KdTree& tree() const { return tree_; }  // Over the surface.
  // Into the surface: what is moved when the submap is aligned with another; all directions of
  // normals have their share.
  const std::vector<int>& sample() const { return sample_; }
  const std::vector<View>& views() const { return views_; }
  // A sphere around the surface.
  const Eigen::Vector3d& center() const { return center_; }
  double radius_m() const { return radius_m_; }
  // The memory it takes, about, without the submap.
  size_t bytes() const;

 private:
  void CollectViews(const std::vector<SubmapPoint>& submap_points);
  // Everything that follows from the surface.
  void IndexSurface();

  std::shared_ptr<const Submap> submap_;
  double voxel_m_ = 0;
  std::vector<SurfacePoint> surface_;
  KdTree tree_;
  std::vector<int> sample_;
  std::vector<View> views_;
  Eigen::Vector3d center_ = Eigen::Vector3d::Zero();
  double radius_m_ = 0;
};

using PreparedSubmaps = std::vector<std::shared_ptr<const PreparedSubmap>>;

// True if something of one may lie within `reach_m` of something of the other.
bool Meet(const PreparedSubmap& a, const PreparedSubmap& b, const Pose& T_a_b, double reach_m = 0);

// All surfaces in the odom frame; see surface.h.
std::vector<SurfacePoint> JoinSurfaces(const PreparedSubmaps& submaps, size_t max_points,
                                       double* voxel_m);

}  // namespace isthmus::matching
