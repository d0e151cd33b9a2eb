// Poses as 56 bytes: qx qy qz qw tx ty tz, little-endian float64.
#pragma once

#include <string>

#include "core/pose.h"
#include "storage/byte_stream.h"

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

// Identity when the reader runs out of bytes.
inline Pose ReadPose(ByteReader& reader) {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d translation;
  for (int i = 0; i < 4; ++i) rotation.coeffs()[i] = reader.Read<double>();
  for (int i = 0; i < 3; ++i) translation[i] = reader.Read<double>();
  return reader.ok() ? Pose(rotation, translation) : Pose();
}

inline Pose UnpackPose(const std::string& bytes) {
  ByteReader reader(bytes);
  return ReadPose(reader);
}

}  // namespace isthmus::storage
