// The part of the map that messages ask for: a box, a sphere, an oriented box, a polygon or a
// corridor.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cmath>
#include <utility>
#include <variant>

#include "api/convert/geometry.h"
#include "core/records/map_reading.h"
#include "isthmus/v1/map_service.pb.h"

namespace isthmus::convert {

// InvalidArgument, saying what to give, for what is not finite, empty, or too much.
absl::StatusOr<Box> CheckedBox(const v1::Box& box);
absl::StatusOr<RegionQuery::Sphere> CheckedSphere(const v1::Sphere& sphere);
absl::StatusOr<OrientedBox> CheckedShape(const v1::OrientedBox& message);
absl::StatusOr<Polygon> CheckedShape(const v1::Polygon& message);
absl::StatusOr<Corridor> CheckedShape(const v1::Corridor& message);
void PutHeights(const HeightBand& heights, v1::HeightBand* message);

template <typename Message>
class ShapePutter {
 public:
  explicit ShapePutter(Message& message) : message_(message) {}

  void operator()(const std::monostate&) const {}
  void operator()(const OrientedBox& box) const {
    *message_.mutable_oriented_box()->mutable_t_map_box() = ToMessage(box.T_map_box);
    *message_.mutable_oriented_box()->mutable_size() = ToMessage(box.size);
  }
  void operator()(const Polygon& polygon) const {
    for (const Eigen::Vector2d& corner : polygon.corners) {
      v1::Polygon::Corner& added = *message_.mutable_polygon()->add_corners();
      added.set_x(corner.x());
      added.set_y(corner.y());
    }
    PutHeights(polygon.heights, message_.mutable_polygon()->mutable_heights());
  }
  void operator()(const Corridor& corridor) const {
    v1::Corridor& put = *message_.mutable_corridor();
    for (const Eigen::Vector3d& point : corridor.path) *put.add_path() = ToMessage(point);
    put.set_width_m(corridor.width_m);
    PutHeights(corridor.heights, put.mutable_heights());
  }

 private:
  Message& message_;
};

// Into an empty message.
template <typename Record, typename Message>
void PutPlace(const Record& record, Message& message) {
  if (record.box) *message.mutable_box() = ToMessage(*record.box);
  if (record.sphere) {
    *message.mutable_sphere()->mutable_center() = ToMessage(record.sphere->center);
    message.mutable_sphere()->set_radius_m(record.sphere->radius_m);
  }
  std::visit(ShapePutter<Message>(message), record.shape);
}

template <typename Part, typename Record>
absl::Status TakeShape(const Part& part, Record& record) {
  auto shape = CheckedShape(part);
  if (!shape.ok()) return shape.status();
  record.shape = *std::move(shape);
  return absl::OkStatus();
}

// Box, sphere and shape, checked.
template <typename Message, typename Record>
absl::Status TakePlace(const Message& request, Record& record) {
  if (request.has_box()) {
    const auto box = CheckedBox(request.box());
    if (!box.ok()) return box.status();
    record.box = *box;
  }
  if (request.has_sphere()) {
    const auto sphere = CheckedSphere(request.sphere());
    if (!sphere.ok()) return sphere.status();
    record.sphere = *sphere;
  }
  absl::Status status;
  if (request.has_oriented_box()) status = TakeShape(request.oriented_box(), record);
  if (request.has_polygon()) status = TakeShape(request.polygon(), record);
  if (request.has_corridor()) status = TakeShape(request.corridor(), record);
  return status;
}

}  // namespace isthmus::convert
