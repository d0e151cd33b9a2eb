#include <absl/strings/match.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "client/readers/folder/folder_recording.h"
#include "client/readers/messages/message_recording.h"
#include "client/readers/packets/live_recording.h"
#include "client/readers/packets/maker.h"
#include "client/readers/packets/packet_decoder.h"
#include "client/readers/packets/pcap_recording.h"
#include "client/readers/recording.h"

namespace isthmus::readers {
namespace {

// Of .pcap (of micro- and nanoseconds, of either byte order) and .pcapng.
bool IsCapture(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  std::array<char, 4> head{};
  uint32_t magic = 0;
  if (!std::ifstream(path, std::ios::binary).read(head.data(), head.size())) return false;
  std::memcpy(&magic, head.data(), sizeof(magic));
  return magic == 0xA1B2C3D4 || magic == 0xD4C3B2A1 || magic == 0xA1B23C4D || magic == 0x4D3CB2A1 ||
         magic == 0x0A0D0D0A;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Recording>> OpenRecording(const std::string& path) {
  if (absl::StrContains(path, "://")) return OpenLiveRecording(path);
  if (IsCapture(path)) return OpenPcapRecording(path);
  if (IsMessageFile(path)) {
    return OpenMessageRecording(path, {MakeDecoderOf, MakeOusterDecoder});
  }
  return OpenFolderRecording(path);
}

}  // namespace isthmus::readers
