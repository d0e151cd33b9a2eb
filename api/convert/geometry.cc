#include "api/convert/geometry.h"

#include <absl/strings/str_cat.h>

#include <Eigen/Geometry>

namespace isthmus::convert {

v1::Vector3 ToMessage(const Eigen::Vector3d& vector) {
  v1::Vector3 message;
  message.set_x(vector.x());
  message.set_y(vector.y());
  message.set_z(vector.z());
  return message;
}

v1::Pose ToMessage(const Pose& pose) {
  v1::Pose message;
  *message.mutable_translation() = ToMessage(pose.translation());
  v1::Quaternion& rotation = *message.mutable_rotation();
  rotation.set_x(pose.rotation().x());
  rotation.set_y(pose.rotation().y());
  rotation.set_z(pose.rotation().z());
  rotation.set_w(pose.rotation().w());
  return message;
}

v1::StampedPose ToMessage(const StampedPose& pose) {
  v1::StampedPose message;
  message.set_stamp_ns(pose.stamp_ns);
  *message.mutable_pose() = ToMessage(pose.pose);
  return message;
}

v1::Box ToMessage(const Box& box) {
  v1::Box message;
  *message.mutable_min() = ToMessage(box.min);
  *message.mutable_max() = ToMessage(box.max);
  return message;
}

Eigen::Vector3d FromMessage(const v1::Vector3& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

Pose FromMessage(const v1::Pose& pose) {
  const v1::Quaternion& q = pose.rotation();
  const Eigen::Quaterniond rotation(q.w(), q.x(), q.y(), q.z());
  if (rotation.squaredNorm() == 0) return Pose(FromMessage(pose.translation()));
  return Pose(rotation, FromMessage(pose.translation()));
}

StampedPose FromMessage(const v1::StampedPose& pose) {
  return {pose.stamp_ns(), FromMessage(pose.pose())};
}

Box FromMessage(const v1::Box& box) {
  Box record;
  record.min = FromMessage(box.min());
  record.max = FromMessage(box.max());
  return record;
}

absl::StatusOr<Eigen::Vector3d> Checked(const v1::Vector3& vector, const char* name) {
  const Eigen::Vector3d result = FromMessage(vector);
  if (!result.allFinite()) {
    return absl::InvalidArgumentError(absl::StrCat(name, " has a number that is not finite"));
  }
  if (result.cwiseAbs().maxCoeff() > kMaxCoordinateM) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, " lies more than ", kMaxCoordinateM, " m away: are these metres?"));
  }
  return result;
}

absl::StatusOr<Pose> Checked(const v1::Pose& pose, const char* name) {
  const auto translation = Checked(pose.translation(), name);
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

void AddUpperTriangle(const Matrix6d& matrix, google::protobuf::RepeatedField<double>* numbers) {
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) numbers->Add(matrix(row, column));
  }
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

}  // namespace isthmus::convert
