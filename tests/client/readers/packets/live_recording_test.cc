#include "client/readers/packets/live_recording.h"

#include <absl/strings/str_cat.h>
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>
#include <future>
#include <thread>

#include "client/readers/packets/live/udp_uri.h"
#include "tests/client/readers/packets/packet_writer.h"

namespace isthmus::readers {
namespace {

using ::testing::HasSubstr;
using testing::VelodynePacketOf;

// A socket of 127.0.0.N, from which packets go to a port of 127.0.0.1.
class LiveSender {
 public:
  explicit LiveSender(const char* address = "127.0.0.1") : socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in own = Address(address, 0);
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&own), sizeof(own)), 0);
  }
  ~LiveSender() { close(socket_); }

  // A port that nobody has.
  static uint16_t FreePort() {
    LiveSender probe;
    sockaddr_in own = {};
    socklen_t size = sizeof(own);
    getsockname(probe.socket_, reinterpret_cast<sockaddr*>(&own), &size);
    return ntohs(own.sin_port);
  }

  void Send(uint16_t port, const std::string& bytes, const char* to = "127.0.0.1") {
    sockaddr_in address = Address(to, port);
    sendto(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&address),
           sizeof(address));
  }
  void SendTurns(uint16_t port, int packets) {
    for (int i = 0; i < packets; ++i) Send(port, VelodynePacketOf({}, i, 0));
  }

 private:
  static sockaddr_in Address(const char* text, uint16_t port) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    inet_pton(AF_INET, text, &address.sin_addr);
    return address;
  }
  int socket_;
};

std::unique_ptr<ScanReader> Listen(const std::string& uri, const ReadOptions& options = {}) {
  const auto recording = OpenLiveRecording(uri);
  EXPECT_TRUE(recording.ok()) << recording.status();
  auto reader = (*recording)->OpenScans(0, options);
  EXPECT_TRUE(reader.ok()) << reader.status();
  return *std::move(reader);
}

TEST(LiveRecording, ReadsWhatComes) {
  for (const char* address : {"", "127.0.0.1"}) {
    const uint16_t port = LiveSender::FreePort();
    const auto reader = Listen(absl::StrCat("udp://", address, ":", port));
    LiveSender sender;
    sender.Send(port, "what is no packet");
    sender.SendTurns(port, 151);
    for (int i = 0; i < 2; ++i) {
      const auto scan = reader->Next();
      ASSERT_TRUE(scan.ok()) << scan.status();
      ASSERT_TRUE(*scan);
      EXPECT_EQ((*scan)->payload.width, 75u * 12 * 32);
      EXPECT_EQ((*scan)->name, absl::StrCat("scan ", i, " of udp ", port));
    }
    EXPECT_EQ(reader->sensor(), "vlp16");
    EXPECT_FALSE(reader->Assumptions().empty());
  }
}

TEST(LiveRecording, InterruptWakesAtOnceAndForAll) {
  const uint16_t port = LiveSender::FreePort();
  const auto reader = Listen(absl::StrCat("udp://127.0.0.1:", port));
  auto next = std::async(std::launch::async, [&] { return reader->Next(); });
  reader->Interrupt();
  const auto scan = next.get();
  ASSERT_TRUE(scan.ok());
  EXPECT_FALSE(*scan);
  LiveSender().SendTurns(port, 151);
  EXPECT_FALSE(*reader->Next());
  EXPECT_FALSE(*reader->Next());
}

TEST(LiveRecording, LeavesOutASecondSensorAndSaysSoOnce) {
  const uint16_t port = LiveSender::FreePort();
  const auto reader = Listen(absl::StrCat("udp://:", port));
  LiveSender first("127.0.0.1"), second("127.0.0.2");
  for (int i = 0; i < 76; ++i) {
    first.Send(port, VelodynePacketOf({}, i, 0));
    second.Send(port, VelodynePacketOf({}, i + 30, 0));
  }
  const auto error = reader->Next();
  EXPECT_THAT(std::string(error.status().message()), HasSubstr("127.0.0.2"));
  const auto scan = reader->Next();
  ASSERT_TRUE(scan.ok() && *scan);
  EXPECT_EQ((*scan)->payload.width, 75u * 12 * 32);
}

TEST(LiveRecording, CountsWhatTheKernelDropped) {
  const uint16_t port = LiveSender::FreePort();
  const auto reader = Listen(absl::StrCat("udp://127.0.0.1:", port));
  // More than any buffer holds, 80 MB of the kernel's count; then what tells of it.
  LiveSender sender;
  sender.SendTurns(port, 35'000);
  bool told = false;
  // The rest of the buffer; a packet that came after the loss must follow.
  std::thread more([&] {
    for (int i = 0; i < 3; ++i) sender.SendTurns(port, 76);
  });
  more.join();
  for (int i = 0; i < 600 && !told; ++i) {
    if (i % 100 == 99) sender.SendTurns(port, 152);
    const auto scan = reader->Next();
    told = !scan.ok() && std::string(scan.status().message()).find("lost") != std::string::npos;
    sender.SendTurns(port, 76);
  }
  EXPECT_TRUE(told);
}

TEST(LiveRecording, OustersNeedMetadata) {
  const uint16_t port = LiveSender::FreePort();
  const std::string uri = absl::StrCat("udp://127.0.0.1:", port);
  testing::OusterSource source;
  {
    const auto reader = Listen(uri);
    LiveSender().Send(port, testing::OusterPacket(source, 0));
    const auto error = reader->Next();
    EXPECT_TRUE(absl::IsInvalidArgument(error.status()));
    EXPECT_THAT(std::string(error.status().message()), HasSubstr("give the JSON"));
    EXPECT_FALSE(*reader->Next());
  }
  ReadOptions options;
  options.sensor = "os1-16";
  EXPECT_FALSE((*OpenLiveRecording(uri))->OpenScans(0, options).ok());
  options.metadata = testing::WriteTestFile("os.json", testing::OusterMetadata(source, true));
  const auto reader = Listen(uri, options);
  LiveSender sender;
  for (int column = 0; column < 64; column += 16) {
    sender.Send(port, testing::OusterPacket(source, column));
  }
  source.frame = 2;
  sender.Send(port, testing::OusterPacket(source, 0));
  const auto scan = reader->Next();
  ASSERT_TRUE(scan.ok() && *scan) << scan.status();
  EXPECT_EQ((*scan)->payload.width, 64u * 16);
}

TEST(LiveRecording, JoinsAGroup) {
  const uint16_t port = LiveSender::FreePort();
  const auto recording = OpenLiveRecording(absl::StrCat("udp://239.255.71.9:", port));
  ASSERT_TRUE(recording.ok());
  const auto reader = (*recording)->OpenScans(0, {});
  if (!reader.ok()) GTEST_SKIP() << "no multicast here: " << reader.status();
  // Others may listen, too.
  EXPECT_TRUE((*recording)->OpenScans(0, {}).ok());
}

TEST(LiveRecording, SaysWhoHasThePort) {
  const uint16_t port = LiveSender::FreePort();
  const std::string uri = absl::StrCat("udp://127.0.0.1:", port);
  const auto reader = Listen(uri);
  const auto second = (*OpenLiveRecording(uri))->OpenScans(0, {});
  EXPECT_THAT(std::string(second.status().message()), HasSubstr("is in use"));
  EXPECT_FALSE((*OpenLiveRecording("udp://198.51.100.7:2368"))->OpenScans(0, {}).ok());
}

TEST(UdpUri, ReadsLiteralAddresses) {
  EXPECT_TRUE(live::ParseUdpUri("udp://:2368")->any);
  EXPECT_EQ(live::ParseUdpUri("udp://10.0.0.1:7502")->port, 7502);
  EXPECT_TRUE(live::ParseUdpUri("udp://239.1.2.3:7502")->multicast);
  EXPECT_TRUE(live::ParseUdpUri("udp://[ff02::1%lo]:7502")->multicast);
  EXPECT_FALSE(live::ParseUdpUri("udp://[::1]:7502")->multicast);
  for (const char* bad : {"", "udp://", "udp://:", "udp://:0", "udp://:65536", "udp://:x",
                          "udp://host:2368", "udp://::1:2368", "udp://[::1:2368", "udp://[]:2368",
                          "udp://[fe80::1%nowhere0]:2368", "tcp://:2368", "udp://:-1"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(live::ParseUdpUri(bad).status())) << bad;
  }
}

}  // namespace
}  // namespace isthmus::readers
