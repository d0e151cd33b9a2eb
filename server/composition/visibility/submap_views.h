// The views of a submap: from where its keyframes looked, and how far.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/geometry/range_image.h"
#include "core/map/submap.h"

namespace isthmus::composition {

struct View {
  Pose T_submap_sensor;
  uint16_t keyframe = 0;
  RangeImage image;
};

// Immutable; safe to read from many threads.
struct SubmapViews {
  // In order of keyframe. Keyframes without points, or with a pose that is not finite, have none.
  std::vector<View> views;

  size_t bytes() const;
};

SubmapViews MakeViews(const Submap& submap);

}  // namespace isthmus::composition
