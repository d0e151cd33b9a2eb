// Parts of the merged map that are asked for, as points or as files.
#include <absl/strings/str_cat.h>

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "api/convert/enum_table.h"
#include "api/convert/geometry.h"
#include "api/convert/map.h"

namespace isthmus::convert {
namespace {

// Of a polygon, and points of a path, as the API says: every point of the map is held against them.
constexpr int kMaxCorners = 1000;
// As the API says, and what core/codec takes.
constexpr double kDefaultRoundingM = 0.001, kMinRoundingM = 1e-5, kMaxRoundingM = 0.1;

constexpr std::pair<ExportFormat, v1::ExportMapRequest::Format> kFormats[] = {
    {ExportFormat::kPcdAscii, v1::ExportMapRequest::PCD_ASCII},
    {ExportFormat::kPcdBinary, v1::ExportMapRequest::PCD_BINARY},
    {ExportFormat::kPcdBinaryCompressed, v1::ExportMapRequest::PCD_BINARY_COMPRESSED},
    {ExportFormat::kPly, v1::ExportMapRequest::PLY},
    {ExportFormat::kOctoMapBinary, v1::ExportMapRequest::OCTOMAP_BINARY},
    {ExportFormat::kOctoMapFull, v1::ExportMapRequest::OCTOMAP_FULL},
};

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
    return absl::InvalidArgumentError(
        absl::StrCat("sphere.radius_m is ", sphere.radius_m(), ": give a positive number"));
  }
  return RegionQuery::Sphere{*center, sphere.radius_m()};
}

absl::Status CheckResolution(double resolution_m) {
  if (resolution_m >= 0 && resolution_m <= kMaxCoordinateM) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("resolution_m is ", resolution_m,
                   ": give a positive size, or 0 for the points as composed and the default leaf"));
}

void PutHeights(const HeightBand& heights, v1::HeightBand* message) {
  if (std::isfinite(heights.min_m)) message->set_min_m(heights.min_m);
  if (std::isfinite(heights.max_m)) message->set_max_m(heights.max_m);
}

absl::StatusOr<HeightBand> CheckedHeights(const v1::HeightBand& message) {
  HeightBand heights;
  if (message.has_min_m()) heights.min_m = message.min_m();
  if (message.has_max_m()) heights.max_m = message.max_m();
  // Written so that NaN fails too.
  if (heights.min_m <= heights.max_m) return heights;
  return absl::InvalidArgumentError(absl::StrCat("heights from ", heights.min_m, " to ",
                                                 heights.max_m, ": give the lower one first"));
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
    return absl::InvalidArgumentError(
        absl::StrCat("corridor.width_m is ", corridor.width_m, ": give a positive number"));
  }
  const auto heights = CheckedHeights(message.heights());
  if (!heights.ok()) return heights.status();
  corridor.heights = *heights;
  return corridor;
}

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

template <typename Record, typename Message>
void PutRegion(const Record& record, Message& message) {
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

// Box, sphere, shape and resolution, checked.
template <typename Message, typename Record>
absl::Status TakeRegion(const Message& request, Record& record) {
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
  if (!status.ok()) return status;
  return CheckResolution(request.resolution_m());
}

using Attribute = v1::QueryRegionRequest::Attribute;

void PutAttributes(const RegionQuery& query, v1::QueryRegionRequest& message) {
  if (query.wants_intensity) message.add_attributes(v1::QueryRegionRequest::INTENSITY);
  if (query.wants_robot) message.add_attributes(v1::QueryRegionRequest::ROBOT);
  if (query.wants_stamp) message.add_attributes(v1::QueryRegionRequest::LAST_SEEN);
  // None at all: an empty list would be the usual ones.
  if (message.attributes().empty()) {
    message.add_attributes(v1::QueryRegionRequest::ATTRIBUTE_UNSPECIFIED);
  }
}

absl::Status TakeAttributes(const v1::QueryRegionRequest& request, RegionQuery& query) {
  if (request.attributes().empty()) return absl::OkStatus();
  query.wants_intensity = query.wants_robot = false;
  for (const int attribute : request.attributes()) {
    switch (static_cast<Attribute>(attribute)) {
      case v1::QueryRegionRequest::ATTRIBUTE_UNSPECIFIED:
        break;
      case v1::QueryRegionRequest::INTENSITY:
        query.wants_intensity = true;
        break;
      case v1::QueryRegionRequest::ROBOT:
        query.wants_robot = true;
        break;
      case v1::QueryRegionRequest::LAST_SEEN:
        query.wants_stamp = true;
        break;
      default:
        return absl::InvalidArgumentError(
            absl::StrCat("attribute ", attribute, " is none: give INTENSITY, ROBOT or LAST_SEEN"));
    }
  }
  return absl::OkStatus();
}

// The range is that of core/codec.
absl::Status TakeRounding(const v1::QueryRegionRequest& request, RegionQuery& query) {
  if (request.encoding() != v1::PointCloud::QUANTIZED) {
    if (request.encoding() == v1::PointCloud::ENCODING_UNSPECIFIED ||
        request.encoding() == v1::PointCloud::RAW) {
      return absl::OkStatus();
    }
    return absl::InvalidArgumentError("the encoding is none that is known: give RAW or QUANTIZED");
  }
  query.rounding_m = request.rounding_m() == 0 ? kDefaultRoundingM : request.rounding_m();
  if (*query.rounding_m >= kMinRoundingM && *query.rounding_m <= kMaxRoundingM) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat("rounding_m is ", request.rounding_m(), ": give ",
                                                 kMinRoundingM, " to ", kMaxRoundingM));
}

}  // namespace

v1::QueryRegionRequest ToMessage(const RegionQuery& query) {
  v1::QueryRegionRequest message;
  PutRegion(query, message);
  message.set_component(query.component);
  message.set_robot(query.robot.value());
  message.set_resolution_m(query.resolution_m);
  message.set_max_points(query.max_points);
  for (const SessionId& session : query.sessions) message.add_sessions(session.value());
  message.set_seen_from_ns(query.seen_from_ns);
  message.set_seen_to_ns(query.seen_to_ns);
  PutAttributes(query, message);
  if (query.rounding_m) {
    message.set_encoding(v1::PointCloud::QUANTIZED);
    message.set_rounding_m(*query.rounding_m);
  }
  if (query.resume) *message.mutable_resume() = ToMessage(*query.resume);
  return message;
}

absl::StatusOr<RegionQuery> FromMessage(const v1::QueryRegionRequest& request) {
  RegionQuery query;
  if (absl::Status status = TakeRegion(request, query); !status.ok()) return status;
  query.component = request.component();
  query.robot = RobotId(request.robot());
  query.resolution_m = request.resolution_m();
  query.max_points = request.max_points();
  for (const std::string& session : request.sessions()) query.sessions.emplace_back(session);
  query.seen_from_ns = request.seen_from_ns();
  query.seen_to_ns = request.seen_to_ns();
  if (absl::Status status = TakeAttributes(request, query); !status.ok()) return status;
  if (absl::Status status = TakeRounding(request, query); !status.ok()) return status;
  if (request.has_resume()) query.resume = FromMessage(request.resume());
  return query;
}

v1::RegionPosition ToMessage(const RegionPosition& position) {
  v1::RegionPosition message;
  message.set_run(position.run);
  message.set_revision(position.revision);
  message.set_points(position.points);
  message.set_resolution_m(position.resolution_m);
  return message;
}

RegionPosition FromMessage(const v1::RegionPosition& position) {
  return {position.run(), position.revision(), position.points(), position.resolution_m()};
}

v1::ExportMapRequest ToMessage(const ExportRequest& request) {
  v1::ExportMapRequest message;
  message.set_format(ToMessage(kFormats, request.format));
  message.set_component(request.component);
  message.set_resolution_m(request.resolution_m);
  PutRegion(request, message);
  message.set_robot(request.robot.value());
  message.set_dropped(request.dropped);
  return message;
}

absl::StatusOr<ExportRequest> FromMessage(const v1::ExportMapRequest& request) {
  const auto format = FromMessage(kFormats, request.format(), std::optional<ExportFormat>());
  if (!format) {
    return absl::InvalidArgumentError(
        "name the format of the file: PCD_ASCII, PCD_BINARY, PCD_BINARY_COMPRESSED, PLY, "
        "OCTOMAP_BINARY or OCTOMAP_FULL");
  }
  ExportRequest wanted;
  if (absl::Status status = TakeRegion(request, wanted); !status.ok()) return status;
  wanted.format = *format;
  wanted.component = request.component();
  wanted.resolution_m = request.resolution_m();
  wanted.robot = RobotId(request.robot());
  wanted.dropped = request.dropped();
  return wanted;
}

}  // namespace isthmus::convert
