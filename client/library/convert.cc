#include "client/library/convert.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "core/io/crc32c.h"
#include "core/io/sha256.h"

namespace isthmus::client {
namespace {

v1::Vector3 FromVector(const Eigen::Vector3d& v) {
  v1::Vector3 out;
  out.set_x(v.x());
  out.set_y(v.y());
  out.set_z(v.z());
  return out;
}

Eigen::Vector3d ToVector(const v1::Vector3& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

v1::Pose ToProto(const Pose& pose) {
  v1::Pose out;
  *out.mutable_translation() = FromVector(pose.translation());
  out.mutable_rotation()->set_x(pose.rotation().x());
  out.mutable_rotation()->set_y(pose.rotation().y());
  out.mutable_rotation()->set_z(pose.rotation().z());
  out.mutable_rotation()->set_w(pose.rotation().w());
  return out;
}

v1::CreateSessionRequest ToProto(const SessionWish& wish) {
  v1::CreateSessionRequest request;
  request.set_robot(wish.robot);
  request.set_sensor(wish.sensor);
  *request.mutable_t_base_sensor() = ToProto(wish.T_base_sensor);
  request.set_odometry(wish.odometry);
  return request;
}

std::optional<Matrix6d> FromUpperTriangle(const google::protobuf::RepeatedField<double>& numbers) {
  if (numbers.size() != 21) return std::nullopt;
  Matrix6d matrix;
  int k = 0;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      matrix(row, column) = matrix(column, row) = numbers[k++];
    }
  }
  return matrix;
}

Pose FromProto(const v1::Pose& pose) {
  const v1::Quaternion& q = pose.rotation();
  const Eigen::Quaterniond rotation(q.w(), q.x(), q.y(), q.z());
  if (rotation.squaredNorm() == 0) return Pose(ToVector(pose.translation()));
  return Pose(rotation, ToVector(pose.translation()));
}

v1::Box ToProto(const Box& box) {
  v1::Box out;
  *out.mutable_min() = FromVector(box.min);
  *out.mutable_max() = FromVector(box.max);
  return out;
}

Box FromProto(const v1::Box& box) {
  Box out;
  out.min = ToVector(box.min());
  out.max = ToVector(box.max());
  return out;
}

namespace {

// All but the data.
v1::PointCloud Layout(const PointPayload& payload) {
  v1::PointCloud out;
  out.set_encoding(payload.encoding == PayloadEncoding::kRaw ? v1::PointCloud::RAW
                                                             : v1::PointCloud::QUANTIZED);
  out.set_width(payload.width);
  out.set_height(payload.height);
  out.set_stride(payload.stride);
  out.set_resolution_m(payload.resolution_m);
  for (const PointField& field : payload.fields) {
    v1::PointField* f = out.add_fields();
    f->set_name(field.name);
    f->set_offset(field.offset);
    f->set_count(field.count);
    f->set_type(static_cast<v1::PointField::Type>(field.type));  // The same numbers.
  }
  return out;
}

}  // namespace

v1::PointCloud ToProto(PointPayload payload) {
  v1::PointCloud out = Layout(payload);
  out.set_data(std::move(payload.data));
  return out;
}

v1::QueryRegionRequest ToProto(const RegionQuery& query) {
  v1::QueryRegionRequest out;
  if (query.box) *out.mutable_box() = ToProto(*query.box);
  if (query.sphere) {
    *out.mutable_sphere()->mutable_center() = FromVector(query.sphere->center);
    out.mutable_sphere()->set_radius_m(query.sphere->radius_m);
  }
  out.set_component(query.component);
  out.set_robot(query.robot.value());
  out.set_resolution_m(query.resolution_m);
  return out;
}

v1::ExportMapRequest ToProto(const ExportRequest& request) {
  v1::ExportMapRequest out;
  switch (request.format) {
    case ExportFormat::kPcdAscii:
      out.set_format(v1::ExportMapRequest::PCD_ASCII);
      break;
    case ExportFormat::kPcdBinary:
      out.set_format(v1::ExportMapRequest::PCD_BINARY);
      break;
    case ExportFormat::kPcdBinaryCompressed:
      out.set_format(v1::ExportMapRequest::PCD_BINARY_COMPRESSED);
      break;
    case ExportFormat::kPly:
      out.set_format(v1::ExportMapRequest::PLY);
      break;
    case ExportFormat::kOctoMapBinary:
      out.set_format(v1::ExportMapRequest::OCTOMAP_BINARY);
      break;
    case ExportFormat::kOctoMapFull:
      out.set_format(v1::ExportMapRequest::OCTOMAP_FULL);
      break;
  }
  out.set_component(request.component);
  out.set_resolution_m(request.resolution_m);
  return out;
}

v1::UploadSubmapHeader ToProto(const SubmapUpload& submap) {
  v1::UploadSubmapHeader out;
  out.set_session(submap.id.session.value());
  out.set_index(submap.id.index);
  out.set_first_stamp_ns(submap.first_stamp_ns);
  out.set_last_stamp_ns(submap.last_stamp_ns);
  *out.mutable_t_odom_submap() = ToProto(submap.T_odom_submap);
  for (const StampedPose& keyframe : submap.keyframes) {
    v1::StampedPose* k = out.add_keyframes();
    k->set_stamp_ns(keyframe.stamp_ns);
    *k->mutable_pose() = ToProto(keyframe.pose);
  }
  *out.mutable_cloud() = Layout(submap.cloud);
  out.set_size(submap.cloud.data.size());
  out.set_crc32c(io::Crc32c(submap.cloud.data.data(), submap.cloud.data.size()));
  out.set_sha256(io::Sha256(submap.cloud.data.data(), submap.cloud.data.size()));
  return out;
}

ScanCounts FromProto(const v1::ScanCounts& counts) {
  return {counts.ok(), counts.degenerate(), counts.lost(), counts.rejected()};
}

Session FromProto(const v1::Session& session) {
  Session out;
  out.record.id = SessionId(session.id());
  out.record.robot = RobotId(session.robot());
  out.record.sensor = session.sensor();
  out.record.odometry = session.odometry();
  if (session.has_t_base_sensor()) out.record.T_base_sensor = FromProto(session.t_base_sensor());
  out.record.state =
      session.state() == v1::Session::FINISHED ? SessionState::kFinished : SessionState::kActive;
  out.record.created_ns = session.created_ns();
  out.record.finished_ns = session.finished_ns();
  out.last_sequence = session.last_sequence();
  out.durable_sequence = session.durable_sequence();
  out.scans_processed = session.scans_processed();
  out.scans_rejected = session.scans_rejected();
  out.submap_count = session.submap_count();
  out.point_count = session.point_count();
  out.odometry_ms_mean = session.odometry_ms_mean();
  out.travelled_m = session.travelled_m();
  out.tracking = session.tracking();
  out.input = session.input();
  out.map_bytes = session.map_bytes();
  out.scan_bytes = session.scan_bytes();
  out.quota_bytes = session.quota_bytes();
  out.archive_problem = session.archive_problem();
  out.record.segment = std::max(session.segment(), 1u);
  out.record.first_segment = SessionId(session.first_segment());
  out.segments = std::max(session.segments(), 1u);
  out.scans = FromProto(session.scan_counts());
  out.lost_since_ns = session.lost_since_ns();
  if (session.has_component()) out.component = session.component();
  if (session.has_t_map_odom()) out.T_map_odom = FromProto(session.t_map_odom());
  return out;
}

MapInfo FromProto(const v1::MapInfo& info) {
  MapInfo out;
  out.revision = info.revision();
  for (const std::string& robot : info.robots()) out.robots.emplace_back(robot);
  for (const v1::Component& component : info.components()) {
    Component c;
    c.component = component.component();
    c.reference = SessionId(component.reference_session());
    for (const std::string& session : component.sessions()) c.sessions.emplace_back(session);
    for (const std::string& robot : component.robots()) c.robots.emplace_back(robot);
    c.point_count = component.point_count();
    if (component.has_bounds()) c.bounds = FromProto(component.bounds());
    out.components.push_back(std::move(c));
  }
  out.settled = info.settled();
  out.composition_ms = info.composition_ms();
  out.composition_max_ms = info.composition_max_ms();
  out.estimation_ms = info.estimation_ms();
  out.compositions = info.compositions();
  out.estimations = info.estimations();
  out.placement_ms = info.placement_ms();
  out.placements = info.placements();
  out.submaps = info.submaps();
  out.retired = info.retired();
  out.damaged.assign(info.damaged().begin(), info.damaged().end());
  out.storage_problem = info.storage_problem();
  return out;
}

SubmapStatus FromProto(const v1::Submap& submap) {
  SubmapStatus status;
  SubmapInfo& out = status.info;
  out.id = {SessionId(submap.session()), submap.index()};
  out.robot = RobotId(submap.robot());
  out.T_odom_submap = FromProto(submap.t_odom_submap());
  out.first_sequence = submap.first_sequence();
  out.last_sequence = submap.last_sequence();
  out.first_stamp_ns = submap.first_stamp_ns();
  out.last_stamp_ns = submap.last_stamp_ns();
  out.keyframe_count = submap.keyframe_count();
  out.point_count = submap.point_count();
  if (submap.has_bounds()) out.bounds = FromProto(submap.bounds());
  if (submap.has_component()) status.component = submap.component();
  status.T_map_submap = FromProto(submap.t_map_submap());
  return status;
}

ScanAck FromProto(const v1::StreamScansResponse& ack) {
  ScanAck out;
  out.sequence = ack.sequence();
  if (ack.outcome() == v1::StreamScansResponse::DUPLICATE) out.outcome = ScanOutcome::kDuplicate;
  if (ack.outcome() == v1::StreamScansResponse::REJECTED) out.outcome = ScanOutcome::kRejected;
  out.reason = ack.reason();
  out.tracking = ack.tracking();
  if (ack.has_t_odom_sensor()) out.T_odom_sensor = FromProto(ack.t_odom_sensor());
  if (ack.has_t_map_odom()) out.T_map_odom = FromProto(ack.t_map_odom());
  out.segment = ack.segment();
  out.segment_session = SessionId(ack.segment_session());
  out.lost_since_ns = ack.lost_since_ns();
  out.scans = FromProto(ack.scan_counts());
  out.durable_sequence = ack.durable_sequence();
  out.covariance = FromUpperTriangle(ack.covariance());
  for (const v1::Vector3& d : ack.unobserved_translations()) {
    out.unobserved_translations.push_back(ToVector(d));
  }
  for (const v1::Vector3& d : ack.unobserved_rotations()) {
    out.unobserved_rotations.push_back(ToVector(d));
  }
  out.timing = {ack.timing().features_ms(), ack.timing().matching_ms(), ack.timing().map_ms(),
                ack.timing().total_ms()};
  return out;
}

absl::Status AppendPoints(const v1::PointCloud& cloud, std::vector<MapPoint>& points) {
  // x y z intensity robot, four bytes each.
  constexpr uint32_t kRecord = 20;
  static constexpr const char* kNames[] = {"x", "y", "z", "intensity", "robot"};
  bool right = cloud.fields_size() >= 5 && cloud.stride() >= kRecord &&
               cloud.data().size() == uint64_t{cloud.stride()} * cloud.width();
  for (int i = 0; right && i < 5; ++i) {
    right = cloud.fields(i).name() == kNames[i] && cloud.fields(i).offset() == 4u * i;
  }
  if (cloud.width() == 0 && cloud.data().empty()) return absl::OkStatus();
  if (!right) return absl::DataLossError("the server's points are not x y z intensity robot");
  for (uint32_t i = 0; i < cloud.width(); ++i) {
    MapPoint point;
    static_assert(sizeof(MapPoint) == kRecord);
    std::memcpy(&point, cloud.data().data() + size_t{cloud.stride()} * i, kRecord);
    points.push_back(point);
  }
  return absl::OkStatus();
}

}  // namespace isthmus::client
