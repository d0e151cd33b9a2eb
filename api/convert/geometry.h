// Poses and boxes, from and to the API's messages.
#pragma once

#include <absl/status/statusor.h>
#include <google/protobuf/repeated_field.h>

#include <Eigen/Core>
#include <optional>

#include "core/cloud.h"
#include "core/map/trajectory.h"
#include "core/pose.h"
#include "isthmus/v1/types.pb.h"

namespace isthmus::convert {

// Positions farther than this from their frame's origin are taken for mistakes.
inline constexpr double kMaxCoordinateM = 1e8;

v1::Vector3 ToMessage(const Eigen::Vector3d& vector);
v1::Pose ToMessage(const Pose& pose);
v1::StampedPose ToMessage(const StampedPose& pose);
v1::Box ToMessage(const Box& box);  // The box must not be empty.

// Values of an answer. Identity for a rotation of all zeros.
Eigen::Vector3d FromMessage(const v1::Vector3& vector);
Pose FromMessage(const v1::Pose& pose);
StampedPose FromMessage(const v1::StampedPose& pose);
Box FromMessage(const v1::Box& box);

// Values of a request. `name` is the value's name in messages ("t_base_sensor"). InvalidArgument
// for numbers that are not finite or beyond kMaxCoordinateM.
absl::StatusOr<Eigen::Vector3d> Checked(const v1::Vector3& vector, const char* name);
// Normalises the rotation; a part that is absent is identity. InvalidArgument as above, and for a
// quaternion of all zeros.
absl::StatusOr<Pose> Checked(const v1::Pose& pose, const char* name);

// A symmetric matrix as 21 numbers, row by row; nothing if there are not as many.
void AddUpperTriangle(const Matrix6d& matrix, google::protobuf::RepeatedField<double>* numbers);
std::optional<Matrix6d> FromUpperTriangle(const google::protobuf::RepeatedField<double>& numbers);

}  // namespace isthmus::convert
