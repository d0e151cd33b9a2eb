#include "server/rpc/convert.h"

#include <absl/strings/str_cat.h>

#include <utility>

namespace isthmus::rpc {
namespace {

absl::StatusOr<ScalarType> FromProto(v1::PointField::Type type, const std::string& field) {
  if (type == v1::PointField::TYPE_UNSPECIFIED || !v1::PointField::Type_IsValid(type)) {
    return absl::InvalidArgumentError(
        absl::StrCat("field \"", field, "\" of the cloud has no known type: give INT8 to FLOAT64"));
  }
  return static_cast<ScalarType>(type);  // Same numbers, those of sensor_msgs/PointField.
}

absl::StatusOr<PayloadEncoding> FromProto(v1::PointCloud::Encoding encoding) {
  switch (encoding) {
    case v1::PointCloud::RAW:
      return PayloadEncoding::kRaw;
    case v1::PointCloud::QUANTIZED:
      return PayloadEncoding::kQuantized;
    default:
      return absl::InvalidArgumentError("the cloud names no known encoding: give RAW or QUANTIZED");
  }
}

}  // namespace

absl::StatusOr<Eigen::Vector3d> FromProto(const v1::Vector3& vector, const char* name) {
  const Eigen::Vector3d result(vector.x(), vector.y(), vector.z());
  if (!result.allFinite()) {
    return absl::InvalidArgumentError(absl::StrCat(name, " has a number that is not finite"));
  }
  if (result.cwiseAbs().maxCoeff() > kMaxCoordinateM) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, " lies more than ", kMaxCoordinateM, " m away: are these metres?"));
  }
  return result;
}

absl::StatusOr<Pose> FromProto(const v1::Pose& pose, const char* name) {
  const auto translation = FromProto(pose.translation(), name);
  if (!translation.ok()) return translation.status();
  if (!pose.has_rotation()) return Pose(*translation);
  const v1::Quaternion& q = pose.rotation();
  Eigen::Quaterniond rotation(q.w(), q.x(), q.y(), q.z());
  if (!rotation.coeffs().allFinite()) {
    return absl::InvalidArgumentError(absl::StrCat(name, " has a rotation that is not finite"));
  }
  // Scaled first, so that the squares of very large or small numbers stay within range.
  const double largest = rotation.coeffs().cwiseAbs().maxCoeff();
  if (largest == 0) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, " has a rotation of all zeros: identity is w = 1"));
  }
  rotation.coeffs() /= largest;
  return Pose(rotation, *translation);
}

absl::StatusOr<PointPayload> FromProto(v1::PointCloud&& cloud) {
  PointPayload payload;
  const auto encoding = FromProto(cloud.encoding());
  if (!encoding.ok()) return encoding.status();
  payload.encoding = *encoding;
  payload.width = cloud.width();
  payload.height = cloud.height() == 0 ? 1 : cloud.height();
  payload.stride = cloud.stride();
  payload.resolution_m = cloud.resolution_m();
  for (const v1::PointField& field : cloud.fields()) {
    const auto type = FromProto(field.type(), field.name());
    if (!type.ok()) return type.status();
    const uint32_t count = field.count() == 0 ? 1 : field.count();
    payload.fields.push_back({field.name(), field.offset(), *type, count});
  }
  payload.data = std::move(*cloud.mutable_data());
  return payload;
}

v1::Vector3 ToProto(const Eigen::Vector3d& vector) {
  v1::Vector3 proto;
  proto.set_x(vector.x());
  proto.set_y(vector.y());
  proto.set_z(vector.z());
  return proto;
}

v1::Pose ToProto(const Pose& pose) {
  v1::Pose proto;
  *proto.mutable_translation() = ToProto(pose.translation());
  v1::Quaternion& rotation = *proto.mutable_rotation();
  rotation.set_x(pose.rotation().x());
  rotation.set_y(pose.rotation().y());
  rotation.set_z(pose.rotation().z());
  rotation.set_w(pose.rotation().w());
  return proto;
}

v1::StampedPose ToProto(const StampedPose& pose) {
  v1::StampedPose proto;
  proto.set_stamp_ns(pose.stamp_ns);
  *proto.mutable_pose() = ToProto(pose.pose);
  return proto;
}

v1::ScanCounts ToProto(const ScanCounts& counts) {
  v1::ScanCounts proto;
  proto.set_ok(counts.ok);
  proto.set_degenerate(counts.degenerate);
  proto.set_lost(counts.lost);
  proto.set_rejected(counts.rejected);
  return proto;
}

v1::Box ToProto(const Box& box) {
  v1::Box proto;
  *proto.mutable_min() = ToProto(box.min);
  *proto.mutable_max() = ToProto(box.max);
  return proto;
}

v1::SubmapEdge ToProto(const SubmapEdge& edge) {
  v1::SubmapEdge proto;
  proto.set_submap_a(edge.submap_a);
  proto.set_submap_b(edge.submap_b);
  *proto.mutable_t_a_b() = ToProto(edge.T_a_b);
  AddUpperTriangle(edge.information, proto.mutable_information());
  return proto;
}

void AddUpperTriangle(const Matrix6d& matrix, google::protobuf::RepeatedField<double>* numbers) {
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) numbers->Add(matrix(row, column));
  }
}

}  // namespace isthmus::rpc
