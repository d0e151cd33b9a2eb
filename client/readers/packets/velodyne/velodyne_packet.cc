#include "client/readers/packets/velodyne/velodyne_packet.h"

#include <absl/strings/str_cat.h>

#include "client/readers/packets/laser_geometry.h"
#include "client/readers/packets/packet_decoder.h"

namespace isthmus::readers {
namespace velodyne {

std::optional<int> Packet::bank(int block) const {
  switch (flag(block)) {
    case kUpper:
      return 0;
    case kLower:
      return 1;
    case kThird:
      return 2;
    case kFourth:
      return 3;
    default:
      return std::nullopt;
  }
}

int Packet::blocks() const {
  const bool vls128 = product() == static_cast<uint8_t>(Product::kVls128);
  return vls128 && return_mode() == kDualReturn ? 8 : kBlocks;
}

bool Hdl64IsDual(const Packet& packet) {
  bool turns = false;
  for (int block = 0; block < kBlocks; block += 4) {
    if (packet.azimuth(block) != packet.azimuth(block + 2)) return false;
    turns |= packet.azimuth(block) != packet.azimuth(0);
  }
  return turns;
}

absl::Status CheckPacket(absl::string_view bytes) {
  if (bytes.size() != kPacketBytes) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a packet of ", bytes.size(), " bytes is none of Velodyne's, which have ", kPacketBytes));
  }
  const Packet packet(bytes);
  for (int block = 0; block < packet.blocks(); ++block) {
    if (!packet.bank(block)) {
      return absl::InvalidArgumentError("a packet is none of Velodyne's: a block has another flag");
    }
    if (packet.azimuth(block) >= kTurn) {
      return absl::InvalidArgumentError("a packet of Velodyne's has an azimuth beyond 360 degrees");
    }
  }
  return absl::OkStatus();
}

}  // namespace velodyne

bool IsVelodynePacket(absl::string_view packet) {
  if (packet.size() != velodyne::kPacketBytes) return false;
  return velodyne::Packet(packet).bank(0).has_value();
}

}  // namespace isthmus::readers
