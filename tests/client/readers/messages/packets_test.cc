// Messages of packets: whole turns, single packets, packets that are refused.
#include "client/readers/messages/packet_reader.h"
#include "tests/client/readers/messages/drive_formulas.h"

namespace isthmus::readers {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Messages of /p, as ROS 1 serialises a PacketMsg or a VelodyneScan.
class Packets : public MessageReader {
 public:
  void AddPacketMsg(size_t size) {
    std::string bytes(4, '\0');
    const auto length = static_cast<uint32_t>(size);
    std::memcpy(bytes.data(), &length, 4);
    messages_.push_back(bytes + std::string(size, 'p'));
  }
  void AddVelodyneScan(uint32_t count) {
    std::string bytes(16 + 4 + size_t{count} * (8 + 1206), '\0');
    std::memcpy(bytes.data() + 16, &count, 4);
    messages_.push_back(bytes);
  }
  void AddDamaged() { messages_.push_back("x"); }
  absl::StatusOr<std::optional<Message>> Next() override {
    if (next_ == messages_.size()) return std::nullopt;
    return Message{0, static_cast<int64_t>(next_), messages_[next_++]};
  }

 private:
  std::vector<std::string> messages_;
  size_t next_ = 0;
};

// Joins packets to a scan, whose stride is their number, until it is flushed or has five.
class Joiner : public PacketEcho {
 public:
  explicit Joiner(bool by_flush) : PacketEcho("joined"), by_flush_(by_flush) {}
  absl::Status Add(absl::string_view packet, int64_t arrival_ns,
                   std::vector<RecordedScan>* scans) override {
    std::vector<RecordedScan> one;
    absl::Status status = PacketEcho::Add(packet, arrival_ns, &one);
    if (status.ok() && ++packets_ == 5 && !by_flush_) Flush(scans);
    return status;
  }
  void Flush(std::vector<RecordedScan>* scans) override {
    if (packets_ == 0) return;
    RecordedScan scan;
    scan.payload.stride = packets_;
    scans->push_back(scan);
    packets_ = 0;
  }

 private:
  const bool by_flush_;
  uint32_t packets_ = 0;
};

struct Joined {
  std::vector<uint32_t> packets;  // By scan.
  std::vector<std::string> names, errors;
};

Joined Join(std::unique_ptr<Packets> messages, const std::string& type) {
  const auto reader =
      ReadPackets({"/p", type, "ros1"}, std::move(messages), {},
                  [](absl::string_view, bool turns) { return std::make_unique<Joiner>(turns); });
  Joined joined;
  while (joined.errors.size() < 100) {
    const auto scan = reader->Next();
    if (!scan.ok()) {
      joined.errors.emplace_back(scan.status().message());
      continue;
    }
    if (!scan->has_value()) break;
    joined.packets.push_back((*scan)->payload.stride);
    joined.names.push_back((*scan)->name);
  }
  return joined;
}

TEST(PacketReaderTest, MessagesThatAreTurnsAreScans) {
  auto messages = std::make_unique<Packets>();
  for (const uint32_t count : {76, 75, 3}) messages->AddVelodyneScan(count);
  const Joined joined = Join(std::move(messages), "velodyne_msgs/VelodyneScan");
  EXPECT_THAT(joined.packets, ElementsAre(76, 75, 3));
  EXPECT_THAT(joined.errors, IsEmpty());
}

TEST(PacketReaderTest, PartsOfTurnsAreJoined) {
  auto messages = std::make_unique<Packets>();
  for (int i = 0; i < 6; ++i) messages->AddVelodyneScan(2);
  const Joined joined = Join(std::move(messages), "velodyne_msgs/VelodyneScan");
  EXPECT_THAT(joined.packets, ElementsAre(5, 5, 2));
}

TEST(PacketReaderTest, PacketsThatAreRefusedAreReportedOnceForAScan) {
  auto messages = std::make_unique<Packets>();
  for (int i = 0; i < 3; ++i) messages->AddPacketMsg(10);
  messages->AddDamaged();
  for (int i = 0; i < 7; ++i) messages->AddPacketMsg(100);
  messages->AddPacketMsg(10);
  const Joined joined = Join(std::move(messages), "ouster_ros/PacketMsg");
  EXPECT_THAT(joined.packets, ElementsAre(5, 2));
  EXPECT_THAT(joined.errors, ElementsAre(HasSubstr("left out before scan 0: 4 (too small)"),
                                         HasSubstr("left out before scan 1: 1 (")));
}

TEST(PacketReaderTest, WithoutADecoderItEnds) {
  auto messages = std::make_unique<Packets>();
  messages->AddPacketMsg(100);
  const auto reader = ReadPackets(
      {"/p", "", "ros1"}, std::move(messages), {},
      [](absl::string_view, bool) { return absl::InvalidArgumentError("no such sensor"); });
  EXPECT_THAT(std::string(reader->Next().status().message()), HasSubstr("no such sensor"));
  EXPECT_FALSE((*reader->Next()).has_value());
}

}  // namespace
}  // namespace isthmus::readers
