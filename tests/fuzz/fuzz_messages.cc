// Bags, MCAP files and messages from any bytes: nothing may crash, hang or take all memory.
//
// What begins like a bag or an MCAP file is read as one, every topic of it to its end. Of anything
// else the first byte chooses a message, the rest is its bytes.
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>

#include "client/readers/messages/decode/cloud_message.h"
#include "client/readers/messages/decode/packet_message.h"
#include "client/readers/messages/decode/place_message.h"
#include "client/readers/messages/message_recording.h"
#include "client/readers/stamps.h"

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

void ReadFile(const std::string& bytes) {
  auto file = OpenMessageBytes(BufferSource(bytes), "fuzz");
  if (!file.ok()) return;
  // A packed message takes less than a byte each, but not much less.
  const size_t most = 1'000'000 + bytes.size();
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
  switch (choice / 2 % 8) {
    case 0:
      return Stamp(DecodePointCloud2(encoding, bytes));
    case 1:
      return Stamp(DecodeLivox(encoding, bytes));
    case 2:
      return Stamp(DecodeFoxglove(bytes));
    case 3:
      return (void)DecodeVelodyneScan(encoding, bytes, 0);
    case 4:
      return (void)DecodeOusterPacket(encoding, bytes, 0);
    case 5:
      return (void)DecodeNavSatFix(encoding, bytes, 0);
    case 6:
      return (void)DecodeTransforms(encoding, bytes);
    default:
      return (void)DecodeString(encoding, bytes);
  }
}

}  // namespace
}  // namespace isthmus::readers

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  if (size == 0) return 0;
  if (data[0] == '#' || data[0] == 0x89) {
    isthmus::readers::ReadFile(bytes);
  } else {
    isthmus::readers::ReadMessage(data[0], absl::string_view(bytes).substr(1));
  }
  return 0;
}
