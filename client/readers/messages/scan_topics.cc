#include "client/readers/messages/scan_topics.h"

#include <absl/strings/ascii.h>
#include <absl/strings/match.h>

namespace isthmus::readers {
namespace {

bool IsRos(const MessageTopic& topic) {
  return topic.encoding == "ros1" || topic.encoding == "cdr";
}

}  // namespace

std::optional<PacketList> PacketListOf(const MessageTopic& topic) {
  if (!IsRos(topic)) return std::nullopt;
  if (topic.type == "velodyne_msgs/VelodyneScan") return PacketList::kVelodyneScan;
  if (topic.type == "pandar_msgs/PandarScan") return PacketList::kPandarScan;
  if (topic.type == "nebula_msgs/NebulaPackets") return PacketList::kNebulaPackets;
  if (topic.type == "hesai_ros_driver/UdpFrame") return PacketList::kUdpFrame;
  return std::nullopt;
}

std::optional<ScanMessage> ScanMessageOf(const MessageTopic& topic) {
  if (topic.type == "foxglove.PointCloud" && topic.encoding == "protobuf") {
    return ScanMessage::kFoxglove;
  }
  if (!IsRos(topic)) return std::nullopt;
  if (topic.type == "sensor_msgs/PointCloud2") return ScanMessage::kPointCloud2;
  if (topic.type == "livox_ros_driver/CustomMsg" || topic.type == "livox_ros_driver2/CustomMsg" ||
      topic.type == "livox_interfaces/CustomMsg") {
    return ScanMessage::kLivox;
  }
  if (PacketListOf(topic)) return ScanMessage::kPackets;
  // The same messages hold what the sensor's IMU says, on another topic.
  const bool is_imu = absl::StrContains(topic.name, "imu");
  if ((topic.type == "ouster_ros/PacketMsg" || topic.type == "ouster_sensor_msgs/PacketMsg") &&
      !is_imu) {
    return ScanMessage::kOusterPackets;
  }
  return std::nullopt;
}

bool HasOtherPoints(const MessageTopic& topic) {
  if (ScanMessageOf(topic)) return false;
  for (const char* word : {"pointcloud", "pointfield", "pandarscan", "rslidarscan", "rslidarpacket",
                           "custommsg", "packetmsg", "velodynescan"}) {
    const bool is_imu = absl::StrContains(topic.name, "imu");
    if (!is_imu && absl::StrContains(absl::AsciiStrToLower(topic.type), word)) return true;
  }
  return false;
}

bool IsFixTopic(const MessageTopic& topic) {
  return IsRos(topic) && topic.type == "sensor_msgs/NavSatFix";
}

bool IsStaticTransformTopic(const MessageTopic& topic) {
  return IsRos(topic) && (topic.type == "tf2_msgs/TFMessage" || topic.type == "tf/tfMessage") &&
         absl::EndsWith(topic.name, "tf_static");
}

bool IsMetadataTopic(const MessageTopic& topic) {
  return IsRos(topic) && topic.type == "std_msgs/String" && absl::EndsWith(topic.name, "metadata");
}

}  // namespace isthmus::readers
