// Looks of views at points: that something is there, or that they see through it.
//
// Each look is evidence for or against that something is where the point is, as log odds by Bayes'
// rule, as in Thrun, Burgard and Fox, "Probabilistic Robotics" (2005), section 4.2, with the
// probabilities of limits.h.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/composition/keep_on.h"
#include "server/composition/visibility/submap_views.h"
#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {

// Looks at the same points, from one submap after the other. Refers to the points. Thread
// safe.
class ViewEvidence {
 public:
  explicit ViewEvidence(std::span<const WeightedPoint> points);

  // Gives the log odds of each point by the views, in kLogOddsStep. Whole numbers, so that their
  // sums do not depend on an order. `are_placed`: views and points are of submaps that were placed,
  // each with an error, which widens the margins, and fewer views are asked; otherwise all but that
  // of a point's own keyframe. False when told to end.
  bool Look(const SubmapViews& views, const Pose& T_views_points, bool are_placed,
            const KeepOn& keep_on, std::vector<int32_t>* log_odds) const;

 private:
  // Points that stand together.
  struct Group {
    size_t begin = 0, end = 0;
    Eigen::Vector3f center;
    float radius = 0;
  };
  struct Asking {
    Eigen::Matrix3f R_sensor_points;
    Eigen::Vector3f t_sensor_points;
    float margin_m = 0, margin_per_m = 0;
    int not_keyframe = -1;
  };
  void LookAt(const Group& group, const RangeImage& image, const Asking& asking,
              std::vector<int32_t>* log_odds) const;

  const std::span<const WeightedPoint> points_;
  std::vector<Group> groups_;
};

}  // namespace isthmus::composition
