#include "client/cloud_upload/joined_clouds.h"

#include <absl/strings/str_cat.h>

#include <cstdlib>
#include <utility>

#include "client/cloud_upload/columns.h"
#include "client/cloud_upload/limits.h"

namespace isthmus::cloud_upload {
namespace {

using readers::RecordedScan;

constexpr uint32_t kJoinedBytes = 16;  // Format: four float32.

PointPayload JoinedPayload(std::string points) {
  PointPayload payload;
  payload.fields = {{"x", 0, ScalarType::kFloat32, 1},
                    {"y", 4, ScalarType::kFloat32, 1},
                    {"z", 8, ScalarType::kFloat32, 1},
                    {"intensity", 12, ScalarType::kFloat32, 1}};
  payload.stride = kJoinedBytes;
  payload.width = static_cast<uint32_t>(points.size() / kJoinedBytes);
  payload.data = std::move(points);
  return payload;
}

}  // namespace

JoinedClouds::JoinedClouds(std::unique_ptr<readers::ScanReader> leading,
                           std::vector<MountedClouds> others, Motion motion)
    : leading_(std::move(leading)), motion_(std::move(motion)) {
  for (MountedClouds& clouds : others) {
    others_.push_back({std::move(clouds), std::nullopt, std::nullopt, false});
  }
}

void JoinedClouds::Interrupt() {
  leading_->Interrupt();
  for (Other& other : others_) other.clouds.reader->Interrupt();
}

void JoinedClouds::ReadOn(int64_t stamp_ns, Other& other) {
  while (!other.has_ended && (!other.after || other.after->end_stamp_ns <= stamp_ns)) {
    if (other.after) other.before = std::move(other.after);
    other.after.reset();
    absl::StatusOr<std::optional<RecordedScan>> next = other.clouds.reader->Next();
    if (!next.ok()) {
      errors_.push_back(next.status());
    } else if (next->has_value()) {
      other.after = **std::move(next);
    } else {
      other.has_ended = true;
    }
  }
}

absl::Status JoinedClouds::Join(const RecordedScan& cloud, int64_t stamp_ns,
                                const Pose& T_leading_sensor, std::string& points) {
  const std::optional<Pose> moved = motion_(stamp_ns, cloud.end_stamp_ns);
  if (!moved) return absl::NotFoundError(absl::StrCat(cloud.name, ": no pose at its stamp"));
  const auto columns = ReadColumns(cloud.payload);
  if (!columns.ok()) {
    return absl::Status(columns.status().code(),
                        absl::StrCat(cloud.name, ": ", columns.status().message()));
  }
  const Pose T_joined_sensor = *moved * T_leading_sensor;
  for (size_t i = 0; i < (*columns)[0].size(); ++i) {
    const Eigen::Vector3d given((*columns)[0][i], (*columns)[1][i], (*columns)[2][i]);
    // Rays that never came back stand at the sensor itself, and would be a point of another's.
    if (!(given.norm() > kNoReturnM)) continue;
    Eigen::Vector4f point;
    point.head<3>() = (T_joined_sensor * given).cast<float>();
    point.w() = (*columns)[3].empty() ? 0.0F : static_cast<float>((*columns)[3][i]);
    points.append(reinterpret_cast<const char*>(point.data()), kJoinedBytes);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::optional<RecordedScan>> JoinedClouds::Next() {
  if (!errors_.empty()) {
    absl::Status error = std::move(errors_.front());
    errors_.pop_front();
    return error;
  }
  absl::StatusOr<std::optional<RecordedScan>> leading = leading_->Next();
  if (!leading.ok() || !leading->has_value()) return leading;
  RecordedScan& scan = **leading;
  std::string points;
  if (absl::Status status = Join(scan, scan.end_stamp_ns, Pose(), points);
      !status.ok() && !absl::IsNotFound(status)) {
    return status;
  } else if (absl::IsNotFound(status)) {
    return leading;  // Without a pose it is of no use to others either: counted by who reads.
  }
  for (Other& other : others_) {
    ReadOn(scan.end_stamp_ns, other);
    const auto away = [&scan](const std::optional<RecordedScan>& cloud) {
      return cloud ? std::abs(cloud->end_stamp_ns - scan.end_stamp_ns) : kSameTurnNs + 1;
    };
    std::optional<RecordedScan>& nearest =
        away(other.before) <= away(other.after) ? other.before : other.after;
    if (away(nearest) > kSameTurnNs) continue;
    absl::Status status = Join(*nearest, scan.end_stamp_ns, other.clouds.T_leading_sensor, points);
    if (!status.ok()) errors_.push_back(std::move(status));
    nearest.reset();
  }
  scan.payload = JoinedPayload(std::move(points));
  return leading;
}

}  // namespace isthmus::cloud_upload
