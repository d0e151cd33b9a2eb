// The types of messages that scans are made of.
#pragma once

#include <absl/strings/string_view.h>

#include <cstdint>
#include <optional>
#include <string>

#include "client/readers/messages/decode/packet_message.h"
#include "client/readers/messages/message_file.h"

namespace isthmus::readers {

enum class ScanMessage : uint8_t {
  kPointCloud2,
  kFoxglove,
  kLivox,
  kPackets,  // A list of them, of any maker.
  kOusterPackets,
};

// The layout of a topic's lists of packets; empty for one of something else.
std::optional<PacketList> PacketListOf(const MessageTopic& topic);

// Empty for a topic that no scans are read from.
std::optional<ScanMessage> ScanMessageOf(const MessageTopic& topic);

// True if a topic has points, but in messages that are not understood.
bool HasOtherPoints(const MessageTopic& topic);

bool IsFixTopic(const MessageTopic& topic);
bool IsStaticTransformTopic(const MessageTopic& topic);
// True if its messages may be the metadata of Ouster's sensors.
bool IsMetadataTopic(const MessageTopic& topic);

}  // namespace isthmus::readers
