#include <Eigen/Geometry>
#include <array>
#include <bit>
#include <optional>
#include <string>
#include <utility>

#include "client/readers/messages/decode/cloud_message.h"
#include "client/readers/messages/decode/protobuf_reader.h"
#include "core/codec/column.h"
#include "core/codec/payload_layout.h"
#include "core/codec/ring_lines.h"

namespace isthmus::readers {
namespace {

// google.protobuf.Timestamp.
int64_t ReadProtobufTime(absl::string_view bytes) {
  uint64_t seconds = 0, nanos = 0;
  ProtobufReader reader(bytes);
  for (ProtobufField field; reader.Next(field);) {
    if (field.number == 1) seconds = field.value;
    if (field.number == 2) nanos = field.value;
  }
  // Unsigned: what is damaged overflows without harm.
  return static_cast<int64_t>(seconds * 1'000'000'000 + nanos);
}

// foxglove.PackedElementField; of an unknown type: false.
bool ReadElementField(absl::string_view bytes, PointField& element) {
  // By foxglove.PackedElementField.NumericType.
  constexpr std::array<ScalarType, 9> kTypes = {
      ScalarType{0},       ScalarType::kUint8,   ScalarType::kInt8,
      ScalarType::kUint16, ScalarType::kInt16,   ScalarType::kUint32,
      ScalarType::kInt32,  ScalarType::kFloat32, ScalarType::kFloat64};
  element.type = ScalarType{0};
  ProtobufReader reader(bytes);
  for (ProtobufField field; reader.Next(field);) {
    if (field.number == 1) element.name = std::string(field.bytes);
    if (field.number == 2) element.offset = static_cast<uint32_t>(field.value);
    if (field.number == 3 && field.value < kTypes.size()) element.type = kTypes[field.value];
  }
  return reader.ok() && SizeOf(element.type) > 0;
}

// The fixed64 fields 1 to N of a message: foxglove.Vector3, foxglove.Quaternion.
template <size_t N>
bool ReadDoubles(absl::string_view bytes, std::array<double, N>& values) {
  ProtobufReader reader(bytes);
  for (ProtobufField field; reader.Next(field);) {
    if (field.number >= 1 && field.number <= N) {
      values[field.number - 1] = std::bit_cast<double>(field.value);
    }
  }
  return reader.ok();
}

// foxglove.Pose: T_frame_cloud. Empty where it is damaged, not finite or no rotation.
std::optional<Eigen::Isometry3d> ReadPose(absl::string_view bytes) {
  std::array<double, 3> position = {};
  std::array<double, 4> turn = {};  // x y z w; all 0, as of a message without it: none.
  bool ok = true;
  ProtobufReader reader(bytes);
  for (ProtobufField field; reader.Next(field);) {
    if (field.number == 1) ok &= ReadDoubles(field.bytes, position);
    if (field.number == 2) ok &= ReadDoubles(field.bytes, turn);
  }
  const Eigen::Vector3d shift(position[0], position[1], position[2]);
  Eigen::Quaterniond rotation(turn[3], turn[0], turn[1], turn[2]);
  if (rotation.coeffs().isZero(0)) rotation.setIdentity();
  if (!ok || !reader.ok() || !shift.allFinite() || !rotation.coeffs().allFinite() ||
      rotation.norm() < 0.5) {
    return std::nullopt;
  }
  return Eigen::Translation3d(shift) * rotation.normalized();
}

// Moves the returns; what is no return stays none.
absl::Status MovePoints(const Eigen::Isometry3d& T_frame_cloud, PointPayload& payload) {
  const std::array<const PointField*, 3> axes = {codec::FindField(payload, {"x"}),
                                                 codec::FindField(payload, {"y"}),
                                                 codec::FindField(payload, {"z"})};
  for (const PointField* axis : axes) {
    if (axis == nullptr ||
        (axis->type != ScalarType::kFloat32 && axis->type != ScalarType::kFloat64)) {
      return absl::InvalidArgumentError(
          "the message has a pose, but x, y and z are not all float32 or float64");
    }
  }
  for (uint64_t i = 0; i < codec::PointCount(payload); ++i) {
    char* const record = payload.data.data() + i * payload.stride;
    Eigen::Vector3d p;
    for (size_t k = 0; k < 3; ++k) {
      const char* const at = record + axes[k]->offset;
      p[static_cast<Eigen::Index>(k)] = axes[k]->type == ScalarType::kFloat32
                                            ? codec::LoadAs<float>(at)
                                            : codec::LoadAs<double>(at);
    }
    const Eigen::Vector3f seen = p.cast<float>();
    if (!codec::IsReturn({.x = seen.x(), .y = seen.y(), .z = seen.z()})) continue;
    p = T_frame_cloud * p;
    for (size_t k = 0; k < 3; ++k) {
      char* const at = record + axes[k]->offset;
      const double value = p[static_cast<Eigen::Index>(k)];
      if (axes[k]->type == ScalarType::kFloat32) {
        codec::StoreAs(static_cast<float>(value), at);
      } else {
        codec::StoreAs(value, at);
      }
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<CloudMessage> DecodeFoxglove(absl::string_view bytes) {
  CloudMessage cloud;
  PointPayload& payload = cloud.payload;
  absl::string_view data, pose;
  ProtobufReader reader(bytes);
  for (ProtobufField field; reader.Next(field);) {
    if (field.number == 3) pose = field.bytes;
    if (field.number == 1) cloud.header.stamp_ns = ReadProtobufTime(field.bytes);
    if (field.number == 2) cloud.header.frame = std::string(field.bytes);
    if (field.number == 4) payload.stride = static_cast<uint32_t>(field.value);
    if (field.number == 5) {
      PointField element;
      if (ReadElementField(field.bytes, element)) payload.fields.push_back(std::move(element));
      if (payload.fields.size() > codec::kMaxFields) break;
    }
    if (field.number == 6) data = field.bytes;
  }
  if (!reader.ok()) return TooShort("foxglove.PointCloud");
  if (payload.stride > 0) payload.width = static_cast<uint32_t>(data.size() / payload.stride);
  payload.data = std::string(data);
  if (absl::Status status = codec::CheckLayout(payload); !status.ok()) return status;
  const std::optional<Eigen::Isometry3d> T_frame_cloud = ReadPose(pose);
  if (!T_frame_cloud) return absl::InvalidArgumentError("the cloud's pose is not valid");
  if (!T_frame_cloud->matrix().isIdentity(0)) {
    if (absl::Status status = MovePoints(*T_frame_cloud, payload); !status.ok()) return status;
  }
  return cloud;
}

}  // namespace isthmus::readers
