// The scans of a topic whose messages are packets.
#pragma once

#include <absl/status/statusor.h>

#include <functional>
#include <memory>
#include <string>

#include "client/readers/messages/message_file.h"
#include "client/readers/messages/scan_topics.h"
#include "client/readers/packets/packet_decoder.h"
#include "client/readers/recording.h"

namespace isthmus::readers {

// Makes the decoder of a topic's packets, once the first message shows a packet and whether
// messages are whole turns. Null for what is no packet of a known sensor.
using DecoderMaker = std::function<absl::StatusOr<std::unique_ptr<PacketDecoder>>(
    absl::string_view packet, bool messages_are_turns)>;

// Packets that the decoder refuses are reported once for each message, or stretch of messages with
// one packet each, with their number.
std::unique_ptr<ScanReader> ReadPackets(const MessageTopic& topic,
                                        std::unique_ptr<MessageReader> messages,
                                        const ReadOptions& options, DecoderMaker make_decoder);

}  // namespace isthmus::readers
