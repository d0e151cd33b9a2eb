// The score of single placements of one map on another, as SearchPlanar has it of all shifts.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "server/matching/search/birds_eye_image.h"
#include "server/matching/search/planar_pose.h"

namespace isthmus::matching {

class PlanarScore {
 public:
  // The cells of `moved` are laid on an image made by MakeReferenceImage; both must outlive it.
  // `free_stride`: every n-th free cell is asked and counts n-fold.
  PlanarScore(const BirdsEyeImage& reference, const BirdsEyeCells& moved, size_t free_stride);

  // Sum over the moved cells of the products with the image. Ends early where it is no more than
  // `least`, with a number up to that: free cells never add to it.
  double Of(const PlanarPose& pose, double least) const;

 private:
  const BirdsEyeImage& reference_;
  const BirdsEyeCells& moved_;
  const size_t free_stride_;
  // By cell of the image what a wall is asked for, side by side: its planes of normals and walls.
  std::vector<Eigen::Vector3f> walls_;
};

}  // namespace isthmus::matching
