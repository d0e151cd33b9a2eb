#include "api/convert/map.h"

#include <absl/strings/str_cat.h>

#include <optional>
#include <string>
#include <utility>

#include "api/convert/enum_table.h"
#include "api/convert/geometry.h"

namespace isthmus::convert {
namespace {

constexpr std::pair<ExportFormat, v1::ExportMapRequest::Format> kFormats[] = {
    {ExportFormat::kPcdAscii, v1::ExportMapRequest::PCD_ASCII},
    {ExportFormat::kPcdBinary, v1::ExportMapRequest::PCD_BINARY},
    {ExportFormat::kPcdBinaryCompressed, v1::ExportMapRequest::PCD_BINARY_COMPRESSED},
    {ExportFormat::kPly, v1::ExportMapRequest::PLY},
    {ExportFormat::kOctoMapBinary, v1::ExportMapRequest::OCTOMAP_BINARY},
    {ExportFormat::kOctoMapFull, v1::ExportMapRequest::OCTOMAP_FULL},
};

v1::Component ComponentMessage(const Component& component) {
  v1::Component message;
  message.set_component(component.component);
  message.set_reference_session(component.reference.value());
  for (const SessionId& session : component.sessions) message.add_sessions(session.value());
  for (const RobotId& robot : component.robots) message.add_robots(robot.value());
  message.set_point_count(component.point_count);
  if (!component.bounds.empty()) *message.mutable_bounds() = ToMessage(component.bounds);
  return message;
}

Component ComponentOf(const v1::Component& component) {
  Component record;
  record.component = component.component();
  record.reference = SessionId(component.reference_session());
  for (const std::string& session : component.sessions()) record.sessions.emplace_back(session);
  for (const std::string& robot : component.robots()) record.robots.emplace_back(robot);
  record.point_count = component.point_count();
  if (component.has_bounds()) record.bounds = FromMessage(component.bounds());
  return record;
}

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

template <typename Message>
void PutRegion(const std::optional<Box>& box, const std::optional<RegionQuery::Sphere>& sphere,
               Message& message) {
  if (box) *message.mutable_box() = ToMessage(*box);
  if (!sphere) return;
  *message.mutable_sphere()->mutable_center() = ToMessage(sphere->center);
  message.mutable_sphere()->set_radius_m(sphere->radius_m);
}

// Box, sphere and resolution, checked.
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
  return CheckResolution(request.resolution_m());
}

}  // namespace

v1::MapInfo ToMessage(const MapInfo& info) {
  v1::MapInfo message;
  message.set_revision(info.revision);
  for (const RobotId& robot : info.robots) message.add_robots(robot.value());
  for (const Component& component : info.components) {
    *message.add_components() = ComponentMessage(component);
  }
  message.set_settled(info.settled);
  message.set_composition_ms(info.composition_ms);
  message.set_composition_max_ms(info.composition_max_ms);
  message.set_estimation_ms(info.estimation_ms);
  message.set_placement_ms(info.placement_ms);
  message.set_compositions(info.compositions);
  message.set_estimations(info.estimations);
  message.set_placements(info.placements);
  message.set_submaps(info.submaps);
  message.set_retired(info.retired);
  for (const std::string& problem : info.damaged) message.add_damaged(problem);
  message.set_storage_problem(info.storage_problem);
  if (info.datum) *message.mutable_datum() = ToMessage(*info.datum);
  return message;
}

MapInfo FromMessage(const v1::MapInfo& info) {
  MapInfo record;
  record.revision = info.revision();
  for (const std::string& robot : info.robots()) record.robots.emplace_back(robot);
  for (const v1::Component& component : info.components()) {
    record.components.push_back(ComponentOf(component));
  }
  record.settled = info.settled();
  record.composition_ms = info.composition_ms();
  record.composition_max_ms = info.composition_max_ms();
  record.estimation_ms = info.estimation_ms();
  record.placement_ms = info.placement_ms();
  record.compositions = info.compositions();
  record.estimations = info.estimations();
  record.placements = info.placements();
  record.submaps = info.submaps();
  record.retired = info.retired();
  record.damaged.assign(info.damaged().begin(), info.damaged().end());
  record.storage_problem = info.storage_problem();
  if (info.has_datum()) record.datum = FromMessage(info.datum());
  return record;
}

v1::Datum ToMessage(const Datum& datum) {
  v1::Datum message;
  message.set_latitude_deg(datum.latitude_deg);
  message.set_longitude_deg(datum.longitude_deg);
  message.set_altitude_m(datum.altitude_m);
  message.set_heading_deg(datum.heading_deg);
  message.set_given_ns(datum.given_ns);
  return message;
}

Datum FromMessage(const v1::Datum& datum) {
  return {.latitude_deg = datum.latitude_deg(),
          .longitude_deg = datum.longitude_deg(),
          .altitude_m = datum.altitude_m(),
          .heading_deg = datum.heading_deg(),
          .given_ns = datum.given_ns()};
}

v1::Submap ToMessage(const SubmapStatus& status) {
  const SubmapInfo& info = status.info;
  v1::Submap message;
  message.set_session(info.id.session.value());
  message.set_index(info.id.index);
  message.set_robot(info.robot.value());
  *message.mutable_t_odom_submap() = ToMessage(info.T_odom_submap);
  message.set_first_sequence(info.first_sequence);
  message.set_last_sequence(info.last_sequence);
  message.set_first_stamp_ns(info.first_stamp_ns);
  message.set_last_stamp_ns(info.last_stamp_ns);
  message.set_keyframe_count(info.keyframe_count);
  message.set_point_count(info.point_count);
  if (!info.bounds.empty()) *message.mutable_bounds() = ToMessage(info.bounds);
  if (status.component) {
    message.set_component(*status.component);
    *message.mutable_t_map_submap() = ToMessage(status.T_map_submap);
  }
  return message;
}

SubmapStatus FromMessage(const v1::Submap& submap) {
  SubmapStatus status;
  SubmapInfo& info = status.info;
  info.id = {SessionId(submap.session()), submap.index()};
  info.robot = RobotId(submap.robot());
  info.T_odom_submap = FromMessage(submap.t_odom_submap());
  info.first_sequence = submap.first_sequence();
  info.last_sequence = submap.last_sequence();
  info.first_stamp_ns = submap.first_stamp_ns();
  info.last_stamp_ns = submap.last_stamp_ns();
  info.keyframe_count = submap.keyframe_count();
  info.point_count = submap.point_count();
  if (submap.has_bounds()) info.bounds = FromMessage(submap.bounds());
  if (submap.has_component()) status.component = submap.component();
  status.T_map_submap = FromMessage(submap.t_map_submap());
  return status;
}

v1::Frame ToMessage(TrajectoryFrame frame) {
  return frame == TrajectoryFrame::kMap ? v1::MAP : v1::ODOM;
}

absl::StatusOr<TrajectoryFrame> FromMessage(v1::Frame frame) {
  if (frame == v1::ODOM) return TrajectoryFrame::kOdom;
  if (frame == v1::MAP) return TrajectoryFrame::kMap;
  return absl::InvalidArgumentError("name the frame of the trajectory: ODOM or MAP");
}

v1::QueryRegionRequest ToMessage(const RegionQuery& query) {
  v1::QueryRegionRequest message;
  PutRegion(query.box, query.sphere, message);
  message.set_component(query.component);
  message.set_robot(query.robot.value());
  message.set_resolution_m(query.resolution_m);
  return message;
}

absl::StatusOr<RegionQuery> FromMessage(const v1::QueryRegionRequest& request) {
  RegionQuery query;
  if (absl::Status status = TakeRegion(request, query); !status.ok()) return status;
  query.component = request.component();
  query.robot = RobotId(request.robot());
  query.resolution_m = request.resolution_m();
  return query;
}

v1::ExportMapRequest ToMessage(const ExportRequest& request) {
  v1::ExportMapRequest message;
  message.set_format(ToMessage(kFormats, request.format));
  message.set_component(request.component);
  message.set_resolution_m(request.resolution_m);
  PutRegion(request.box, request.sphere, message);
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
