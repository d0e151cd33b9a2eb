#include "client/readers/packets/maker.h"

#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <filesystem>
#include <utility>
#include <vector>

#include "client/readers/packets/hesai/hesai_model.h"
#include "client/readers/packets/hesai/hesai_packet.h"
#include "client/readers/packets/limits.h"
#include "client/readers/packets/livox/livox_packet.h"
#include "client/readers/packets/ouster/ouster_metadata.h"
#include "client/readers/packets/ouster/ouster_packet.h"
#include "client/readers/packets/robosense/robosense_packet.h"
#include "client/readers/packets/velodyne/velodyne_model.h"
#include "client/readers/packets/velodyne/velodyne_packet.h"
#include "core/io/file_io.h"

namespace isthmus::readers {
namespace {

namespace fs = std::filesystem;

absl::StatusOr<std::string> ReadDescription(const std::string& path) {
  std::error_code error;
  if (fs::is_regular_file(path, error) && fs::file_size(path, error) > kMaxDescriptionBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, " is too large for a metadata or calibration file"));
  }
  return io::ReadFile(path);
}

// The contents, if that is metadata of packets of that size.
std::optional<std::string> MetadataIn(const fs::path& path, size_t packet_bytes) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return std::nullopt;
  absl::StatusOr<std::string> text = ReadDescription(path);
  if (!text.ok()) return std::nullopt;
  const absl::StatusOr<ouster::Metadata> metadata = ouster::ParseMetadata(*text);
  if (!metadata.ok()) return std::nullopt;
  const bool fits =
      packet_bytes == 0 || ouster::PacketLayout(*metadata).packet_bytes() == packet_bytes;
  return fits ? std::optional(*std::move(text)) : std::nullopt;
}

absl::StatusOr<std::string> FindMetadata(const std::string& capture, size_t packet_bytes) {
  if (capture.empty()) {
    return absl::InvalidArgumentError(
        "a sensor of Ouster's needs its metadata: give the JSON that it sends for "
        "http://SENSOR/api/v1/sensor/metadata");
  }
  const fs::path beside = fs::path(capture).replace_extension(".json");
  if (std::optional<std::string> text = MetadataIn(beside, packet_bytes)) return *std::move(text);
  std::error_code error;
  std::vector<std::string> found;
  const fs::path folder = fs::absolute(capture, error).parent_path();
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->path().extension() != ".json") continue;
    std::optional<std::string> text = MetadataIn(it->path(), packet_bytes);
    if (text) found.push_back(*std::move(text));
    if (found.size() > 1) break;
  }
  if (found.size() == 1) return found[0];
  return absl::InvalidArgumentError(absl::StrCat(
      capture, " holds packets of Ouster's, which need the sensor's metadata: ",
      found.empty() ? "give the JSON that was recorded with them, or put it beside the file as "
                    : "several .json files in the folder would fit; give one, or call it ",
      beside.filename().string()));
}

absl::StatusOr<std::unique_ptr<PacketDecoder>> MakeOuster(const ReadOptions& options,
                                                          const std::string& capture,
                                                          size_t packet_bytes) {
  absl::StatusOr<std::string> metadata = options.metadata.empty()
                                             ? FindMetadata(capture, packet_bytes)
                                             : ReadDescription(options.metadata);
  if (!metadata.ok()) return metadata.status();
  absl::StatusOr<std::unique_ptr<PacketDecoder>> decoder = MakeOusterDecoder(*metadata);
  if (decoder.ok() || options.metadata.empty()) return decoder;
  return absl::Status(decoder.status().code(),
                      absl::StrCat(options.metadata, ": ", decoder.status().message()));
}

// Makes the decoder of a maker whose packets say all but the angles.
absl::StatusOr<std::unique_ptr<PacketDecoder>> Make(Maker maker, PacketOptions options) {
  if (options.sensor == "spinning" || options.sensor == "auto") options.sensor.clear();
  if (maker == Maker::kLivox) return MakeLivoxDecoder(options);
  if (maker == Maker::kRobosense) return MakeRobosenseDecoder(options);
  return maker == Maker::kHesai ? MakeHesaiDecoder(options) : MakeVelodyneDecoder(options);
}

}  // namespace

const char* PacketsOf(Maker maker) {
  switch (maker) {
    case Maker::kVelodyne:
      return "Velodyne packets";
    case Maker::kOuster:
      return "Ouster packets";
    case Maker::kHesai:
      return "Hesai packets";
    case Maker::kLivox:
      return "Livox packets";
    case Maker::kRobosense:
      break;
  }
  return "RoboSense packets";
}

std::optional<Maker> MakerOf(absl::string_view beginning, size_t length) {
  const bool velodyne = length == velodyne::kPacketBytes && beginning.size() > 1 &&
                        (beginning[0] == '\xFF' || beginning[0] == '\xDD') &&
                        (beginning[1] == '\xEE' || beginning[1] == '\xDD');
  if (velodyne && (beginning.size() < length || IsVelodynePacket(beginning))) {
    return Maker::kVelodyne;
  }
  if (hesai::MayBeHesaiPacket(beginning, length)) return Maker::kHesai;
  if (robosense::MayBeRobosensePacket(beginning, length)) return Maker::kRobosense;
  if (livox::MayBeLivoxPacket(beginning, length)) return Maker::kLivox;
  if (ouster::MayBeOusterPacket(beginning, length)) return Maker::kOuster;
  return std::nullopt;
}

absl::StatusOr<Maker> MakerOfSensor(const std::string& sensor) {
  const std::string name = absl::AsciiStrToLower(sensor);
  const bool ouster =
      name.find("ouster") != std::string::npos || (name.size() > 2 && name.substr(0, 2) == "os");
  if (ouster) return Maker::kOuster;
  if (hesai::ModelOfName(sensor).ok()) return Maker::kHesai;
  for (const char* word : {"rs", "helios", "ruby", "robosense"}) {
    if (absl::StartsWith(name, word)) return Maker::kRobosense;
  }
  for (const char* word : {"livox", "mid", "avia", "hap", "horizon", "tele"}) {
    if (absl::StartsWith(name, word)) return Maker::kLivox;
  }
  const absl::StatusOr<velodyne::Model> model = velodyne::ModelOfName(sensor);
  if (!model.ok()) return model.status();
  return Maker::kVelodyne;
}

absl::StatusOr<std::unique_ptr<PacketDecoder>> MakeDecoder(Maker maker, const ReadOptions& options,
                                                           std::optional<int64_t> utc_offset_ns,
                                                           const std::string& capture,
                                                           size_t packet_bytes) {
  if (maker == Maker::kOuster) return MakeOuster(options, capture, packet_bytes);
  PacketOptions packets;
  packets.sensor = options.sensor;
  packets.utc_offset_ns = utc_offset_ns;
  if (!options.calibration.empty()) {
    absl::StatusOr<std::string> text = ReadDescription(options.calibration);
    if (!text.ok()) return text.status();
    if (text->empty()) {
      return absl::InvalidArgumentError(absl::StrCat(options.calibration, " is empty"));
    }
    packets.calibration = *std::move(text);
  }
  return Make(maker, packets);
}

absl::StatusOr<std::unique_ptr<PacketDecoder>> MakeDecoderOf(absl::string_view packet,
                                                             const PacketOptions& options) {
  const std::optional<Maker> maker = MakerOf(packet, packet.size());
  if (!maker || *maker == Maker::kOuster) return nullptr;
  return Make(*maker, options);
}

}  // namespace isthmus::readers
