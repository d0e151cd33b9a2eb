// A sensor_msgs/PointCloud2 as it comes over the wire, for the reader of recordings to decode.
#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <sensor_msgs/PointCloud2.h>

#include <algorithm>
#include <string>

namespace isthmus::ros1 {

struct RawCloud {
  std::string bytes;  // The message, serialised.
};

}  // namespace isthmus::ros1

// To roscpp it is a PointCloud2.
namespace ros::message_traits {

template <>
struct MD5Sum<isthmus::ros1::RawCloud> : MD5Sum<sensor_msgs::PointCloud2> {
  static const char* value(const isthmus::ros1::RawCloud&) {
    return MD5Sum<sensor_msgs::PointCloud2>::value();
  }
  using MD5Sum<sensor_msgs::PointCloud2>::value;
};
template <>
struct DataType<isthmus::ros1::RawCloud> : DataType<sensor_msgs::PointCloud2> {
  static const char* value(const isthmus::ros1::RawCloud&) {
    return DataType<sensor_msgs::PointCloud2>::value();
  }
  using DataType<sensor_msgs::PointCloud2>::value;
};
template <>
struct Definition<isthmus::ros1::RawCloud> : Definition<sensor_msgs::PointCloud2> {
  static const char* value(const isthmus::ros1::RawCloud&) {
    return Definition<sensor_msgs::PointCloud2>::value();
  }
  using Definition<sensor_msgs::PointCloud2>::value;
};

}  // namespace ros::message_traits

namespace ros::serialization {

template <>
struct Serializer<isthmus::ros1::RawCloud> {
  template <typename Stream>
  static void write(Stream& stream, const isthmus::ros1::RawCloud& cloud) {
    std::copy(cloud.bytes.begin(), cloud.bytes.end(),
              stream.advance(static_cast<uint32_t>(cloud.bytes.size())));
  }
  template <typename Stream>
  static void read(Stream& stream, isthmus::ros1::RawCloud& cloud) {
    const uint32_t size = stream.getLength();
    const uint8_t* const bytes = stream.advance(size);
    cloud.bytes.assign(bytes, bytes + size);
  }
  static uint32_t serializedLength(const isthmus::ros1::RawCloud& cloud) {
    return static_cast<uint32_t>(cloud.bytes.size());
  }
};

}  // namespace ros::serialization
