// Messages that hold the packets of a LiDAR.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <string>
#include <vector>

namespace isthmus::readers {

struct MessagePacket {
  int64_t arrival_ns = 0;   // Nanoseconds since the Unix epoch.
  absl::string_view bytes;  // The payload of the UDP packet, inside of the message.
  std::string frame = {};   // The points' frame; empty: not told.
};

// The functions below return InvalidArgument, naming what is wrong, for what does not fit.

// A list of packets, in the layouts that drivers have for it: velodyne_msgs/VelodyneScan,
// pandar_msgs/PandarScan, nebula_msgs/NebulaPackets, hesai_ros_driver/UdpFrame. A packet without a
// stamp has that of the message, or arrived when that was recorded.
enum class PacketList : uint8_t { kVelodyneScan, kPandarScan, kNebulaPackets, kUdpFrame };
absl::StatusOr<std::vector<MessagePacket>> DecodePacketList(PacketList list,
                                                            absl::string_view encoding,
                                                            absl::string_view bytes,
                                                            int64_t log_ns);

// ouster_ros/PacketMsg and ouster_sensor_msgs/PacketMsg: one packet, which has no stamp.
absl::StatusOr<std::vector<MessagePacket>> DecodeOusterPacket(absl::string_view encoding,
                                                              absl::string_view bytes,
                                                              int64_t log_ns);

}  // namespace isthmus::readers
