// Poses as 56 bytes: qx qy qz qw tx ty tz, little-endian float64.
#pragma once

#include <cmath>
#include <string>

#include "core/byte_stream.h"
#include "core/pose.h"

namespace isthmus::storage {

inline void AppendPose(const Pose& pose, std::string& out) {
  for (int i = 0; i < 4; ++i) AppendBytes(pose.rotation().coeffs()[i], out);
  for (int i = 0; i < 3; ++i) AppendBytes(pose.translation()[i], out);
}

inline std::string PackPose(const Pose& pose) {
  std::string bytes;
  AppendPose(pose, bytes);
  return bytes;
}

// Identity when the reader runs out of bytes. The appended pose bit by bit: Pose's constructor
// would normalise a quaternion anew that is of unit length already, and change its last digits.
inline Pose ReadPose(ByteReader& reader) {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d translation;
  for (int i = 0; i < 4; ++i) rotation.coeffs()[i] = reader.Read<double>();
  for (int i = 0; i < 3; ++i) translation[i] = reader.Read<double>();
  if (!reader.ok()) return Pose();
  Pose pose(rotation, translation);
  constexpr double kUnitLength = 1e-12;
  if (std::abs(rotation.squaredNorm() - 1) < kUnitLength) {
    const_cast<Eigen::Quaterniond&>(pose.rotation()) = rotation;
  }
  return pose;
}

inline Pose UnpackPose(const std::string& bytes) {
  ByteReader reader(bytes);
  return ReadPose(reader);
}

}  // namespace isthmus::storage
