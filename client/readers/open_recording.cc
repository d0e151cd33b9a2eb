#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "client/readers/folder/folder_recording.h"
#include "client/readers/messages/message_recording.h"
#include "client/readers/packed_file.h"
#include "client/readers/packets/live_recording.h"
#include "client/readers/packets/maker.h"
#include "client/readers/packets/packet_decoder.h"
#include "client/readers/packets/pcap_recording.h"
#include "client/readers/recording.h"
#include "client/readers/split_bag.h"

namespace isthmus::readers {
namespace {

// True for .pcap (of micro- and nanoseconds, of either byte order) and .pcapng.
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

PacketDecoderFactories Decoders() { return {MakeDecoderOf, MakeOusterDecoder}; }

absl::Status IsPacked(const std::string& path, const std::string& command) {
  return absl::InvalidArgumentError(
      absl::StrCat(path, " is compressed; unpack it first, with `", command, "`"));
}

// A folder without scans of its own.
absl::StatusOr<std::unique_ptr<Recording>> OpenFolderOfFiles(const std::string& path,
                                                             const absl::Status& no_scans) {
  if (const std::vector<std::string> bags = ListBags(path); !bags.empty()) {
    auto drive = OpenSplitBag(path, bags);
    if (!drive.ok()) return drive.status();
    return MakeMessageRecording(*std::move(drive), path, Decoders());
  }
  const std::string command = UnpackCommand(path);
  return command.empty() ? no_scans : IsPacked("what is in " + path, command);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Recording>> OpenRecording(const std::string& path) {
  if (absl::StrContains(path, "://")) return OpenLiveRecording(path);
  if (IsCapture(path)) return OpenPcapRecording(path);
  if (IsMessageFile(path)) return OpenMessageRecording(path, Decoders());
  std::error_code error;
  const bool is_folder = std::filesystem::is_directory(path, error);
  // The values of a .bin may begin with any bytes.
  if (!is_folder && !absl::EndsWith(path, ".bin")) {
    if (const std::string command = UnpackCommand(path); !command.empty()) {
      return IsPacked(path, command);
    }
  }
  absl::StatusOr<std::unique_ptr<Recording>> scans = OpenFolderRecording(path);
  if (!is_folder || !absl::IsNotFound(scans.status())) return scans;
  return OpenFolderOfFiles(path, scans.status());
}

}  // namespace isthmus::readers
