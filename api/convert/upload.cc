// Uploaded submaps, still encoded.
#include <utility>

#include "api/convert/cloud.h"
#include "api/convert/geometry.h"
#include "api/convert/session.h"
#include "core/io/crc32c.h"
#include "core/io/sha256.h"

namespace isthmus::convert {

v1::UploadSubmapHeader ToMessage(const SubmapUpload& submap) {
  v1::UploadSubmapHeader message;
  message.set_session(submap.id.session.value());
  message.set_index(submap.id.index);
  message.set_first_stamp_ns(submap.first_stamp_ns);
  message.set_last_stamp_ns(submap.last_stamp_ns);
  *message.mutable_t_odom_submap() = ToMessage(submap.T_odom_submap);
  for (const StampedPose& keyframe : submap.keyframes) {
    *message.add_keyframes() = ToMessage(keyframe);
  }
  const std::string& data = submap.cloud.data;
  *message.mutable_cloud() = LayoutMessage(submap.cloud);
  message.set_size(data.size());
  message.set_crc32c(io::Crc32c(data.data(), data.size()));
  message.set_sha256(io::Sha256(data.data(), data.size()));
  return message;
}

absl::StatusOr<SubmapUpload> FromMessage(v1::UploadSubmapHeader&& header) {
  SubmapUpload record;
  record.id = {SessionId(header.session()), header.index()};
  record.first_stamp_ns = header.first_stamp_ns();
  record.last_stamp_ns = header.last_stamp_ns();
  const auto pose = Checked(header.t_odom_submap(), "t_odom_submap");
  if (!pose.ok()) return pose.status();
  record.T_odom_submap = *pose;
  for (const v1::StampedPose& keyframe : header.keyframes()) {
    const auto T_submap_sensor = Checked(keyframe.pose(), "keyframes.pose");
    if (!T_submap_sensor.ok()) return T_submap_sensor.status();
    record.keyframes.push_back({keyframe.stamp_ns(), *T_submap_sensor});
  }
  auto cloud = FromMessage(std::move(*header.mutable_cloud()));
  if (!cloud.ok()) return cloud.status();
  record.cloud = *std::move(cloud);
  return record;
}

}  // namespace isthmus::convert
