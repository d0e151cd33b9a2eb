#include "api/convert/region_place.h"

#include <absl/strings/str_cat.h>

namespace isthmus::convert {
namespace {

// Corners of a polygon, and points of a path, as the API says: every point of the map is held
// against them.
constexpr int kMaxCorners = 1000;

absl::StatusOr<HeightBand> CheckedHeights(const v1::HeightBand& message) {
  HeightBand heights;
  if (message.has_min_m()) heights.min_m = message.min_m();
  if (message.has_max_m()) heights.max_m = message.max_m();
  // Written so that NaN fails too.
  if (heights.min_m <= heights.max_m) return heights;
  return absl::InvalidArgumentError(absl::StrCat("heights from ", heights.min_m, " to ",
                                                 heights.max_m, ": give the lower one first"));
}

}  // namespace

absl::StatusOr<Box> CheckedBox(const v1::Box& box) {
  const auto min = Checked(box.min(), "box.min");
  if (!min.ok()) return min.status();
  const auto max = Checked(box.max(), "box.max");
  if (!max.ok()) return max.status();
  if ((min->array() > max->array()).any()) {
    return absl::InvalidArgumentError(absl::StrCat("box.min (", min->x(), ", ", min->y(), ", ",
                                                   min->z(), ") exceeds box.max (", max->x(), ", ",
                                                   max->y(), ", ", max->z(), "): exchange them"));
  }
  Box record;
  record.min = *min;
  record.max = *max;
  return record;
}

absl::StatusOr<RegionQuery::Sphere> CheckedSphere(const v1::Sphere& sphere) {
  const auto center = Checked(sphere.center(), "sphere.center");
  if (!center.ok()) return center.status();
  // Written so that NaN fails too.
  if (!(sphere.radius_m() > 0 && sphere.radius_m() <= kMaxCoordinateM)) {
    return absl::InvalidArgumentError(absl::StrCat("sphere.radius_m is ", sphere.radius_m(),
                                                   ": give more than 0 and at most ",
                                                   kMaxCoordinateM, " m"));
  }
  return RegionQuery::Sphere{*center, sphere.radius_m()};
}

void PutHeights(const HeightBand& heights, v1::HeightBand* message) {
  if (std::isfinite(heights.min_m)) message->set_min_m(heights.min_m);
  if (std::isfinite(heights.max_m)) message->set_max_m(heights.max_m);
}

absl::StatusOr<OrientedBox> CheckedShape(const v1::OrientedBox& message) {
  const auto pose = Checked(message.t_map_box(), "t_map_box");
  if (!pose.ok()) return pose.status();
  const auto size = Checked(message.size(), "size");
  if (!size.ok()) return size.status();
  if ((size->array() > 0).all()) return OrientedBox{*pose, *size};
  return absl::InvalidArgumentError("size of oriented_box: give three positive numbers");
}

absl::StatusOr<Polygon> CheckedShape(const v1::Polygon& message) {
  if (message.corners_size() < 3 || message.corners_size() > kMaxCorners) {
    return absl::InvalidArgumentError(absl::StrCat("the polygon has ", message.corners_size(),
                                                   " corners: give 3 to ", kMaxCorners));
  }
  Polygon polygon;
  for (const v1::Polygon::Corner& corner : message.corners()) {
    v1::Vector3 at;
    at.set_x(corner.x());
    at.set_y(corner.y());
    const auto checked = Checked(at, "polygon.corners");
    if (!checked.ok()) return checked.status();
    polygon.corners.push_back(checked->head<2>());
  }
  const auto heights = CheckedHeights(message.heights());
  if (!heights.ok()) return heights.status();
  polygon.heights = *heights;
  return polygon;
}

absl::StatusOr<Corridor> CheckedShape(const v1::Corridor& message) {
  if (message.path_size() < 1 || message.path_size() > kMaxCorners) {
    return absl::InvalidArgumentError(absl::StrCat("the corridor's path has ", message.path_size(),
                                                   " points: give 1 to ", kMaxCorners));
  }
  Corridor corridor;
  for (const v1::Vector3& point : message.path()) {
    const auto checked = Checked(point, "corridor.path");
    if (!checked.ok()) return checked.status();
    corridor.path.push_back(*checked);
  }
  corridor.width_m = message.width_m();
  if (!(corridor.width_m > 0 && corridor.width_m <= kMaxCoordinateM)) {
    return absl::InvalidArgumentError(absl::StrCat("corridor.width_m is ", corridor.width_m,
                                                   ": give more than 0 and at most ",
                                                   kMaxCoordinateM, " m"));
  }
  const auto heights = CheckedHeights(message.heights());
  if (!heights.ok()) return heights.status();
  corridor.heights = *heights;
  return corridor;
}

}  // namespace isthmus::convert
