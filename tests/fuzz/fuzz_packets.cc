// Bytes of anybody, taken for the packets, metadata, calibrations and captures of sensors. The
// first byte says for which; see corpus/packets.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/readers/packets/maker.h"
#include "client/readers/packets/packet_decoder.h"
#include "client/readers/packets/pcap_recording.h"
#include "core/codec/column.h"
#include "core/codec/payload_layout.h"

namespace isthmus::readers {
namespace {

// Scans that come out must keep their promises.
void CheckScans(const std::vector<RecordedScan>& scans) {
  for (const RecordedScan& scan : scans) {
    if (!codec::CheckLayout(scan.payload).ok()) std::abort();
  }
}

// Packets of `size` bytes out of the bytes, each with an arrival before it.
void FeedPackets(PacketDecoder& decoder, absl::string_view bytes, size_t size) {
  std::vector<RecordedScan> scans;
  while (bytes.size() > 8) {
    int64_t arrival_ns = 0;
    bytes.copy(reinterpret_cast<char*>(&arrival_ns), sizeof(arrival_ns));
    bytes.remove_prefix(sizeof(arrival_ns));
    const absl::string_view packet = bytes.substr(0, size);
    (void)decoder.Add(packet, arrival_ns, &scans);
    bytes.remove_prefix(packet.size());
    CheckScans(scans);
    scans.clear();
  }
  decoder.Flush(&scans);
  CheckScans(scans);
  (void)decoder.Assumptions();
}

void TryVelodyne(absl::string_view bytes) {
  auto decoder = MakeVelodyneDecoder({});
  if (decoder.ok()) FeedPackets(**decoder, bytes, 1206);
}

// A calibration, up to the first 0, and the packets behind it.
struct Described {
  PacketOptions options;
  absl::string_view packets;

  explicit Described(absl::string_view bytes) {
    const size_t end = std::min(bytes.find('\0'), bytes.size());
    options.calibration = std::string(bytes.substr(0, end));
    packets = bytes.substr(std::min(end + 1, bytes.size()));
  }
};

void TryCalibration(absl::string_view bytes) {
  const Described described(bytes);
  auto decoder = MakeVelodyneDecoder(described.options);
  if (decoder.ok()) FeedPackets(**decoder, described.packets, 1206);
}

// Packets of any size: one byte says which.
void TryHesai(absl::string_view bytes) {
  const Described described(bytes);
  auto decoder = MakeHesaiDecoder(described.options);
  if (!decoder.ok() || described.packets.empty()) return;
  const size_t sizes[] = {1262, 1194, 1072, 564, 1076, 816, 1087, 831};
  FeedPackets(**decoder, described.packets.substr(1),
              sizes[static_cast<uint8_t>(described.packets[0]) % 8]);
}

void TryLivox(absl::string_view bytes) {
  auto decoder = MakeLivoxDecoder({});
  if (!decoder.ok() || bytes.empty()) return;
  const size_t sizes[] = {1318, 918, 1362, 978, 786, 42, 1278, 36 + 96 * 14, 36 + 8, 36 + 20};
  FeedPackets(**decoder, bytes.substr(1), sizes[static_cast<uint8_t>(bytes[0]) % 10]);
}

// A DIFOP packet, then those with points.
void TryRobosense(absl::string_view bytes) {
  const Described described(bytes);
  auto decoder = MakeRobosenseDecoder(described.options);
  if (decoder.ok()) FeedPackets(**decoder, described.packets, 1248);
}

// Packets in messages, whose sensor the first tells: two bytes are the size of all.
void TryAny(absl::string_view bytes) {
  const Described described(bytes);
  if (described.packets.size() < 2 + 8) return;
  const size_t size = codec::LoadAs<uint16_t>(described.packets.data());
  const absl::string_view packets = described.packets.substr(2);
  auto decoder = MakeDecoderOf(packets.substr(8, size), described.options);
  if (decoder.ok() && *decoder != nullptr) FeedPackets(**decoder, packets, size);
}

void TryOuster(absl::string_view bytes) {
  const size_t end = bytes.find('\0');
  auto decoder = MakeOusterDecoder(std::string(bytes.substr(0, end)));
  if (!decoder.ok() || end == absl::string_view::npos) return;
  const absl::string_view packets = bytes.substr(end + 1);
  // Sizes of one column and two rows, in the corpus.
  for (const size_t size : {44, 100, 84}) FeedPackets(**decoder, packets, size);
}

void TryCapture(absl::string_view bytes) {
  std::string copy(bytes);
  if (copy.empty()) return;
  const auto open = [&] { return fmemopen(copy.data(), copy.size(), "rb"); };
  auto recording = OpenPcapRecording("bytes", open);
  if (!recording.ok()) return;
  for (size_t topic = 0; topic < (*recording)->scan_topics().size(); ++topic) {
    auto reader = (*recording)->OpenScans(topic, {});
    if (!reader.ok()) continue;
    while (true) {
      auto scan = (*reader)->Next();
      if (!scan.ok()) continue;
      if (!*scan) break;
      CheckScans({**std::move(scan)});
    }
  }
  for (size_t topic = 0; topic < (*recording)->gnss_topics().size(); ++topic) {
    (void)(*recording)->ReadFixes(topic);
  }
}

}  // namespace
}  // namespace isthmus::readers

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const absl::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0]) {
    case 'v':
      isthmus::readers::TryVelodyne(bytes);
      break;
    case 'c':
      isthmus::readers::TryCalibration(bytes);
      break;
    case 'h':
      isthmus::readers::TryHesai(bytes);
      break;
    case 'l':
      isthmus::readers::TryLivox(bytes);
      break;
    case 'r':
      isthmus::readers::TryRobosense(bytes);
      break;
    case 'o':
      isthmus::readers::TryOuster(bytes);
      break;
    case 'm':
      isthmus::readers::TryAny(bytes);
      break;
    default:
      isthmus::readers::TryCapture(bytes);
      break;
  }
  return 0;
}
