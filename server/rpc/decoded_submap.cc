#include "server/rpc/decoded_submap.h"

#include <absl/strings/str_cat.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/codec/payload_layout.h"
#include "core/codec/quantized.h"

namespace isthmus::rpc {
namespace {

// Limits of the store, of which it would tell a sender too late: storage/record_rules.h.
constexpr double kMaxPointDistanceM = 5000;
constexpr size_t kMaxKeyframes = std::numeric_limits<uint16_t>::max();

absl::StatusOr<std::vector<Keyframe>> Keyframes(const SubmapUpload& upload) {
  if (upload.keyframes.size() > kMaxKeyframes) {
    return absl::InvalidArgumentError(absl::StrCat("a submap of ", upload.keyframes.size(),
                                                   " keyframes: give at most ", kMaxKeyframes));
  }
  std::vector<Keyframe> keyframes;
  for (const StampedPose& stamped : upload.keyframes) {
    keyframes.push_back({0, stamped.stamp_ns, stamped.pose});
  }
  if (keyframes.empty()) keyframes.push_back({0, upload.last_stamp_ns, Pose()});
  return keyframes;
}

absl::StatusOr<PointPayload> RawCloud(PointPayload cloud) {
  if (cloud.encoding == PayloadEncoding::kQuantized) return codec::Dequantize(cloud);
  if (absl::Status status = codec::CheckLayout(cloud); !status.ok()) return status;
  return cloud;
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
                         ": leave out points that are not finite or beyond 5 km"));
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
  for (size_t i = 0; i < column.size(); ++i) {
    const auto intensity = static_cast<float>(column[i]);
    points[i].intensity = std::isfinite(intensity) ? intensity : 0;  // None, as without the field.
  }
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

absl::StatusOr<Submap> DecodeSubmap(SubmapUpload upload, const RobotId& robot) {
  Submap submap;
  submap.id = upload.id;
  submap.robot = robot;
  submap.first_stamp_ns = upload.first_stamp_ns;
  submap.last_stamp_ns = upload.last_stamp_ns;
  submap.T_odom_submap = upload.T_odom_submap;
  auto keyframes = Keyframes(upload);
  if (!keyframes.ok()) return keyframes.status();
  submap.keyframes = *std::move(keyframes);
  const auto raw = RawCloud(std::move(upload.cloud));
  if (!raw.ok()) return raw.status();
  submap.points.resize(codec::PointCount(*raw));
  absl::Status status = ReadPositions(*raw, submap.points);
  if (status.ok()) status = ReadKeyframes(*raw, submap.keyframes.size(), submap.points);
  if (!status.ok()) return status;
  ReadIntensities(*raw, submap.points);
  return submap;
}

}  // namespace isthmus::rpc
