// Conversion between the API's messages and the types of core/. What comes from outside is checked
// here, so that nothing behind this folder meets a pose that is not finite or a field of unknown
// type.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <string>

#include "core/cloud.h"
#include "core/match.h"
#include "core/point_payload.h"
#include "core/pose.h"
#include "core/session.h"
#include "core/trajectory.h"
#include "isthmus/v1/map_service.pb.h"
#include "isthmus/v1/session_service.pb.h"
#include "isthmus/v1/types.pb.h"

namespace isthmus::rpc {

// Positions farther than this from their frame's origin are taken for mistakes.
inline constexpr double kMaxCoordinateM = 1e8;

// `name` says in messages what the value is ("t_base_sensor"). InvalidArgument for numbers that are
// not finite or beyond kMaxCoordinateM.
absl::StatusOr<Eigen::Vector3d> FromProto(const v1::Vector3& vector, const char* name);

// Normalises the rotation; a part that is absent is identity. InvalidArgument as above, and for a
// quaternion of all zeros.
absl::StatusOr<Pose> FromProto(const v1::Pose& pose, const char* name);

// Takes over the data. InvalidArgument when the encoding or a field's type is not one of the API's;
// whether the layout fits the data is left to core/codec.
absl::StatusOr<PointPayload> FromProto(v1::PointCloud&& cloud);

v1::Vector3 ToProto(const Eigen::Vector3d& vector);
v1::Pose ToProto(const Pose& pose);
v1::StampedPose ToProto(const StampedPose& pose);
v1::ScanCounts ToProto(const ScanCounts& counts);
v1::Box ToProto(const Box& box);  // Of a box that is not empty.
v1::SubmapEdge ToProto(const SubmapEdge& edge);
// Of a symmetric matrix: 21 numbers, row by row.
void AddUpperTriangle(const Matrix6d& matrix, google::protobuf::RepeatedField<double>* numbers);

}  // namespace isthmus::rpc
