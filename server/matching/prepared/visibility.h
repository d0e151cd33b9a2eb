// The visibility of an older submap's surface from a later one.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/pose.h"
#include "server/matching/prepared/prepared_submap.h"

namespace isthmus::matching {

enum class Visibility : uint8_t {
  kNone,     // Out of sight, hidden, or beyond where it is sure.
  kOn,       // Something is where the point is.
  kThrough,  // Nothing is there any more: what was measured lies behind it.
};

// The visibility of every point, given in the older submap's frame, from the views of `later`: on,
// if any view sees it there; else through, if any looks through it.
std::vector<Visibility> VisibilityOf(const std::vector<Eigen::Vector3f>& points,
                                     const PreparedSubmap& later, const Pose& T_later_older);

}  // namespace isthmus::matching
