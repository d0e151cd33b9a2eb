#include "server/rpc/submap_conversion.h"

#include <absl/strings/str_cat.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/codec/payload_layout.h"
#include "core/codec/quantized.h"
#include "server/rpc/convert.h"

namespace isthmus::rpc {
namespace {

constexpr double kMaxPointDistanceM = 1e5;
constexpr int kMaxKeyframes = std::numeric_limits<uint16_t>::max();

absl::StatusOr<std::vector<Keyframe>> Keyframes(const v1::UploadSubmapHeader& header) {
  if (header.keyframes_size() > kMaxKeyframes) {
    return absl::InvalidArgumentError(absl::StrCat("a submap of ", header.keyframes_size(),
                                                   " keyframes: give at most ", kMaxKeyframes));
  }
  std::vector<Keyframe> keyframes;
  for (const v1::StampedPose& stamped : header.keyframes()) {
    const auto pose = FromProto(stamped.pose(), "keyframes.pose");
    if (!pose.ok()) return pose.status();
    keyframes.push_back({0, stamped.stamp_ns(), *pose});
  }
  if (keyframes.empty()) keyframes.push_back({0, header.last_stamp_ns(), Pose()});
  return keyframes;
}

absl::StatusOr<PointPayload> DecodedCloud(v1::PointCloud&& cloud) {
  auto payload = FromProto(std::move(cloud));
  if (!payload.ok()) return payload.status();
  if (payload->encoding == PayloadEncoding::kQuantized) return codec::Dequantize(*payload);
  if (absl::Status status = codec::CheckLayout(*payload); !status.ok()) return status;
  return payload;
}

bool IsUnsigned(ScalarType type) {
  return type == ScalarType::kUint8 || type == ScalarType::kUint16 || type == ScalarType::kUint32;
}

absl::Status ReadPositions(const PointPayload& raw, std::vector<SubmapPoint>& points) {
  float SubmapPoint::*const members[] = {&SubmapPoint::x, &SubmapPoint::y, &SubmapPoint::z};
  const char* const names[] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    const PointField* field = codec::FindField(raw, {names[axis]});
    if (field == nullptr) {
      return absl::InvalidArgumentError(
          absl::StrCat("the cloud has no field \"", names[axis], "\""));
    }
    const std::vector<double> column = codec::ReadColumn(raw, *field);
    for (size_t i = 0; i < column.size(); ++i) {
      if (!(std::abs(column[i]) <= kMaxPointDistanceM)) {
        return absl::InvalidArgumentError(
            absl::StrCat("point ", i, " has ", names[axis], " = ", column[i],
                         ": leave out what is not finite or beyond 100 km"));
      }
      points[i].*members[axis] = static_cast<float>(column[i]);
    }
  }
  return absl::OkStatus();
}

void ReadIntensities(const PointPayload& raw, std::vector<SubmapPoint>& points) {
  const PointField* field = codec::FindField(raw, {"intensity", "i", "reflectivity", "signal"});
  if (field == nullptr) return;
  const std::vector<double> column = codec::ReadColumn(raw, *field);
  for (size_t i = 0; i < column.size(); ++i) points[i].intensity = static_cast<float>(column[i]);
}

absl::Status ReadKeyframes(const PointPayload& raw, size_t keyframes,
                           std::vector<SubmapPoint>& points) {
  const PointField* field = codec::FindField(raw, {"keyframe"});
  if (field == nullptr) return absl::OkStatus();
  if (!IsUnsigned(field->type)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "field \"keyframe\" is ", codec::ToString(field->type), ": give uint8, uint16 or uint32"));
  }
  const std::vector<double> column = codec::ReadColumn(raw, *field);
  for (size_t i = 0; i < column.size(); ++i) {
    if (column[i] >= static_cast<double>(keyframes)) {
      return absl::InvalidArgumentError(absl::StrCat("point ", i, " names keyframe ", column[i],
                                                     " but there are ", keyframes,
                                                     ", counted from 0"));
    }
    points[i].keyframe = static_cast<uint16_t>(column[i]);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Submap> ToSubmap(v1::UploadSubmapHeader&& header, const RobotId& robot) {
  Submap submap;
  submap.id = {SessionId(header.session()), header.index()};
  submap.robot = robot;
  submap.first_stamp_ns = header.first_stamp_ns();
  submap.last_stamp_ns = header.last_stamp_ns();
  const auto pose = FromProto(header.t_odom_submap(), "t_odom_submap");
  if (!pose.ok()) return pose.status();
  submap.T_odom_submap = *pose;
  auto keyframes = Keyframes(header);
  if (!keyframes.ok()) return keyframes.status();
  submap.keyframes = *std::move(keyframes);
  const auto raw = DecodedCloud(std::move(*header.mutable_cloud()));
  if (!raw.ok()) return raw.status();
  submap.points.resize(codec::PointCount(*raw));
  absl::Status status = ReadPositions(*raw, submap.points);
  if (status.ok()) status = ReadKeyframes(*raw, submap.keyframes.size(), submap.points);
  if (!status.ok()) return status;
  ReadIntensities(*raw, submap.points);
  return submap;
}

}  // namespace isthmus::rpc
