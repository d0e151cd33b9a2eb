// The merged map as a message of ROS.
#pragma once

#include <ros/time.h>
#include <sensor_msgs/PointCloud2.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/records/map_reading.h"

namespace isthmus::ros1 {

// Collects the chunks of a region. Fields x y z intensity (float32), robot (uint32): which of the
// server's robots saw the point, to colour by. Not thread safe.
class MapCloud {
 public:
  explicit MapCloud(size_t max_points);

  // False when there are more points than the limit: it is of no use then.
  bool Add(const RegionChunk& chunk);
  bool is_full() const { return full_; }
  int64_t revision() const { return revision_; }
  size_t points() const { return message_.width; }
  // The message; nothing is left here.
  sensor_msgs::PointCloud2 Take(const std::string& frame, const ros::Time& stamp);

 private:
  const size_t max_points_;
  sensor_msgs::PointCloud2 message_;
  int64_t revision_ = 0;
  bool full_ = false;
};

}  // namespace isthmus::ros1
