// Recordings of messages: ROS 1 and ROS 2 bags and MCAP.
#pragma once

#include <absl/status/statusor.h>

#include <functional>
#include <memory>
#include <string>

#include "client/readers/messages/message_file.h"
#include "client/readers/packets/packet_decoder.h"
#include "client/readers/recording.h"

namespace isthmus::readers {

// The makers of decoders of packets: MakeDecoderOf and MakeOusterDecoder. Thread safe. Topics whose
// packets have none cannot be opened (Unimplemented).
struct PacketDecoderFactories {
  // By the first packet; null for one of no known sensor.
  std::function<absl::StatusOr<std::unique_ptr<PacketDecoder>>(absl::string_view packet,
                                                               const PacketOptions&)>
      packets;
  std::function<absl::StatusOr<std::unique_ptr<PacketDecoder>>(const std::string& metadata)> ouster;
};

// Opens what OpenMessageFile does. Scans are read from sensor_msgs/PointCloud2, Livox' CustomMsg,
// lists of packets (decode/packet_message.h), Ouster's PacketMsg and foxglove.PointCloud, fixes
// from sensor_msgs/NavSatFix, transforms from topics that end in tf_static. Topics are sorted by
// name. The END of scans is as in stamps.h. Ouster's metadata are, unless ReadOptions says, those
// of a std_msgs/String on a topic that ends in "metadata", the one next by name, or a .json beside
// the file: that with the file's name, or the only one.
//
// Errors of OpenMessageFile; NotFound, naming the topics, for a recording without scans.
absl::StatusOr<std::unique_ptr<Recording>> OpenMessageRecording(
    const std::string& path, const PacketDecoderFactories& factories);

// The same of a file that was opened. `path`: beside which metadata are looked for; empty: nowhere.
absl::StatusOr<std::unique_ptr<Recording>> MakeMessageRecording(
    std::shared_ptr<const MessageFile> file, const std::string& path,
    const PacketDecoderFactories& factories);

}  // namespace isthmus::readers
