// Bags, MCAP files, databases and messages from any bytes: nothing may crash, hang or take all
// memory.
//
// Bytes that begin like a bag, an MCAP file, a database or a metadata.yaml are read as one, every
// topic to its end. The first byte of any others chooses a message, the rest is its bytes.
#include <stdlib.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>

#include "client/readers/messages/db3/bag_metadata.h"
#include "client/readers/messages/db3/db3_file.h"
#include "client/readers/messages/decode/cloud_message.h"
#include "client/readers/messages/decode/packet_message.h"
#include "client/readers/messages/decode/place_message.h"
#include "client/readers/messages/message_recording.h"
#include "client/readers/messages/unpack.h"
#include "client/readers/stamps.h"
#include "core/io/file_io.h"

namespace isthmus::readers {
namespace {

// A decoder that makes a scan of every packet.
class AnyPacket : public PacketDecoder {
 public:
  absl::Status Add(absl::string_view, int64_t arrival_ns,
                   std::vector<RecordedScan>* scans) override {
    scans->push_back({arrival_ns, {}, {}});
    return absl::OkStatus();
  }
  void Flush(std::vector<RecordedScan>*) override {}
  std::string sensor() const override { return {}; }
  std::vector<std::string> Assumptions() const override { return {}; }
};

PacketDecoderFactories AnyFactories() {
  const auto make = [](const auto&...) { return std::make_unique<AnyPacket>(); };
  return {make, make};
}

void ReadAllScans(const Recording& recording, size_t most) {
  for (size_t topic = 0; topic < recording.scan_topics().size(); ++topic) {
    auto reader = recording.OpenScans(topic, {});
    size_t calls = 0;
    while (reader.ok()) {
      const auto scan = (*reader)->Next();
      if (scan.ok() && !scan->has_value()) break;
      if (++calls > most) abort();  // Every recording ends.
    }
  }
}

void ReadFile(const absl::StatusOr<std::shared_ptr<const MessageFile>>& file, size_t size) {
  if (!file.ok()) return;
  // A packed message takes less than a byte each, but not much less.
  const size_t most = 1'000'000 + size;
  std::vector<size_t> all;
  for (size_t i = 0; i < (*file)->topics().size(); ++i) all.push_back(i);
  auto reader = (*file)->OpenReader(all);
  for (size_t calls = 0; reader.ok(); ++calls) {
    const auto message = (*reader)->Next();
    if (message.ok() && !message->has_value()) break;
    if (calls > most) abort();
  }
  auto recording = MakeMessageRecording(*file, "", AnyFactories());
  if (!recording.ok()) return;
  ReadAllScans(**recording, most);
  for (size_t i = 0; i < (*recording)->gnss_topics().size(); ++i) {
    (void)(*recording)->ReadFixes(i);
  }
  (void)(*recording)->ReadStaticTransforms();
}

// SQLite reads files alone: in memory where there is such a file system.
void ReadDatabase(const std::string& bytes) {
  char name[] = "/dev/shm/fuzz_messages_XXXXXX";
  const int file = mkstemp(name);
  if (file < 0) std::abort();
  close(file);
  if (!io::WriteFile(name, bytes).ok()) std::abort();
  ReadFile(OpenDb3(name), bytes.size());
  unlink(name);
}

// The first byte chooses what a recorder did to a chunk, or that it packed a single message.
void ReadPacked(absl::string_view bytes) {
  if (bytes.empty()) return;
  constexpr uint64_t kClaimed = 1u << 20;
  const auto choice = static_cast<uint8_t>(bytes[0]);
  bytes.remove_prefix(1);
  std::string content;
  if (choice % 4 == 0) return (void)UnpackedMessage("cdr", bytes, &content);
  (void)Unpack(static_cast<Compression>(choice % 4), bytes, kClaimed, &content);
  if (content.size() > kClaimed) std::abort();
}

void ReadList(PacketList list, absl::string_view encoding, absl::string_view bytes) {
  const auto packets = DecodePacketList(list, encoding, bytes, 0);
  if (!packets.ok()) return;
  for (const MessagePacket& packet : *packets) {
    if (packet.bytes.size() > bytes.size()) std::abort();
  }
}

void Stamp(const absl::StatusOr<CloudMessage>& cloud) {
  if (!cloud.ok()) return;
  for (const StampMeaning meaning : {StampMeaning::kByTimes, StampMeaning::kStart}) {
    ScanStamps stamps(meaning, 10);
    (void)stamps.End(cloud->payload, cloud->header.stamp_ns, 1);
    (void)stamps.End(cloud->payload, cloud->header.stamp_ns + 1, 2);
  }
}

void ReadMessage(uint8_t choice, absl::string_view bytes) {
  const char* const encoding = choice % 2 == 0 ? "ros1" : "cdr";
  switch (choice / 2) {
    case 0:
      return Stamp(DecodePointCloud2(encoding, bytes));
    case 1:
      return Stamp(DecodeLivox(encoding, bytes));
    case 2:
      return Stamp(DecodeFoxglove(bytes));
    case 3:
      return ReadList(PacketList::kVelodyneScan, encoding, bytes);
    case 4:
      return (void)DecodeOusterPacket(encoding, bytes, 0);
    case 5:
      return (void)DecodeNavSatFix(encoding, bytes, 0);
    case 6:
      return (void)DecodeTransforms(encoding, bytes);
    case 8:
      return ReadList(PacketList::kPandarScan, encoding, bytes);
    case 9:
      return ReadList(PacketList::kNebulaPackets, encoding, bytes);
    case 10:
      return ReadList(PacketList::kUdpFrame, encoding, bytes);
    case 11:
      return ReadPacked(bytes);
    default:
      return (void)DecodeString(encoding, bytes);
  }
}

}  // namespace
}  // namespace isthmus::readers

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace isthmus::readers;
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  if (size == 0) return 0;
  switch (data[0]) {
    case '#':
    case 0x89:
      ReadFile(OpenMessageBytes(BufferSource(bytes), "fuzz"), size);
      break;
    case 'S':
      ReadDatabase(bytes);
      break;
    case 'r':
      (void)ParseBagMetadata(bytes);
      break;
    default:
      ReadMessage(data[0], absl::string_view(bytes).substr(1));
      break;
  }
  return 0;
}
