#include "client/ros1/map_cloud.h"

#include <sensor_msgs/PointField.h>

#include <utility>

namespace isthmus::ros1 {
namespace {

sensor_msgs::PointField Field(const char* name, uint32_t offset, uint8_t type) {
  sensor_msgs::PointField field;
  field.name = name;
  field.offset = offset;
  field.datatype = type;
  field.count = 1;
  return field;
}

}  // namespace

MapCloud::MapCloud(size_t max_points) : max_points_(max_points) {
  using sensor_msgs::PointField;
  message_.fields = {
      Field("x", 0, PointField::FLOAT32),     Field("y", 4, PointField::FLOAT32),
      Field("z", 8, PointField::FLOAT32),     Field("intensity", 12, PointField::FLOAT32),
      Field("robot", 16, PointField::UINT32), Field("label", 20, PointField::UINT32)};
  message_.point_step = kMapRecordBytes;
  message_.height = 1;
  message_.is_dense = 1U;
}

bool MapCloud::Add(const RegionChunk& chunk) {
  revision_ = chunk.revision;
  full_ = full_ || message_.width + chunk.points.size() > max_points_;
  if (full_) return false;
  const size_t before = message_.data.size(), bytes = chunk.points.size() * kMapRecordBytes;
  message_.data.resize(before + bytes);
  CopyMapRecords(chunk.points, message_.data.data() + before);
  message_.width += static_cast<uint32_t>(chunk.points.size());
  return true;
}

sensor_msgs::PointCloud2 MapCloud::Take(const std::string& frame, const ros::Time& stamp) {
  message_.header.frame_id = frame;
  message_.header.stamp = stamp;
  message_.row_step = message_.width * message_.point_step;
  return std::exchange(message_, {});
}

}  // namespace isthmus::ros1
