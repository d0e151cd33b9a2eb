#include "client/readers/packets/pcap_recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/client/readers/packets/packet_writer.h"

namespace isthmus::readers {
namespace {

using testing::CaptureWriter;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::Link;
using testing::OusterSource;
using testing::Sender;
using ::testing::SizeIs;
using testing::VelodynePacketOf;
using testing::VelodyneSource;
using testing::VelodyneTimeNs;
using testing::WriteTestFile;

constexpr int64_t kCaptureStart = 1'700'000'000LL / 3600 * 3600 * 1'000'000'000;

std::string VelodyneCapture(Link link, const Sender& sender, int packets) {
  CaptureWriter writer(link);
  const VelodyneSource source;
  for (int i = 0; i < packets; ++i) {
    writer.Add(sender, VelodynePacketOf(source, i, 0), kCaptureStart + VelodyneTimeNs(source, i));
  }
  return writer.bytes();
}

std::unique_ptr<Recording> OpenCapture(const std::string& path) {
  auto recording = OpenPcapRecording(path);
  EXPECT_TRUE(recording.ok()) << recording.status();
  return *std::move(recording);
}

struct ReadResult {
  std::vector<RecordedScan> scans;
  std::vector<std::string> errors;
  std::vector<std::string> assumptions;
};

ReadResult ReadAll(const Recording& recording, size_t topic, const ReadOptions& options = {}) {
  ReadResult result;
  auto reader = recording.OpenScans(topic, options);
  EXPECT_TRUE(reader.ok()) << reader.status();
  if (!reader.ok()) return result;
  for (int i = 0; i < 1000; ++i) {
    auto scan = (*reader)->Next();
    if (!scan.ok()) {
      result.errors.emplace_back(scan.status().message());
    } else if (*scan) {
      result.scans.push_back(**std::move(scan));
    } else {
      result.assumptions = (*reader)->Assumptions();
      return result;
    }
  }
  ADD_FAILURE() << "does not end";
  return result;
}

TEST(PcapRecording, ReadsEveryLinkLayerAndBothVersionsOfIp) {
  for (const Link link :
       {Link::kEthernet, Link::kVlan, Link::kCooked, Link::kCooked2, Link::kLoopback, Link::kRaw}) {
    for (const char* address : {"192.168.1.201", "fe80::1"}) {
      const auto recording =
          OpenCapture(WriteTestFile("a.pcap", VelodyneCapture(link, {address, 2369}, 160)));
      ASSERT_THAT(recording->scan_topics(), SizeIs(1));
      const ScanTopic& topic = recording->scan_topics()[0];
      EXPECT_EQ(topic.name, std::string("udp 2369 from ") + address);
      EXPECT_EQ(topic.type, "Velodyne packets");
      EXPECT_EQ(topic.messages, 160u);
      EXPECT_THAT(recording->notes(), IsEmpty());
      const ReadResult result = ReadAll(*recording, 0);
      EXPECT_THAT(result.scans, SizeIs(3));
      EXPECT_THAT(result.errors, IsEmpty());
      EXPECT_EQ(result.scans[0].name, "scan 0 of " + topic.name);
    }
  }
}

void AppendBlock(std::string& bytes, uint32_t type, std::string body) {
  body.resize((body.size() + 3) / 4 * 4);
  testing::Append(bytes, type, 4);
  testing::Append(bytes, body.size() + 12, 4);
  bytes += body;
  testing::Append(bytes, body.size() + 12, 4);
}

// A turn and a bit, from the first of interfaces of these link types.
std::string PcapngCapture(const std::vector<uint16_t>& links) {
  std::string bytes, section;
  testing::Append(section, 0x1A2B3C4D, 4);
  testing::Append(section, 1, 2);
  testing::Append(section, 0, 2);
  testing::Append(section, UINT64_MAX, 8);
  AppendBlock(bytes, 0x0A0D0D0A, section);
  for (const uint16_t link : links) {
    std::string interface;
    testing::Append(interface, link, 2);
    testing::Append(interface, 0, 2);
    testing::Append(interface, 65535, 4);
    AppendBlock(bytes, 1, interface);
  }
  for (int i = 0; i < 80; ++i) {
    const std::string frame =
        testing::Frames(Link::kEthernet, {}, VelodynePacketOf({}, i, 0)).at(0);
    const uint64_t us = static_cast<uint64_t>(kCaptureStart + VelodyneTimeNs({}, i)) / 1000;
    std::string packet;
    testing::Append(packet, 0, 4);
    testing::Append(packet, us >> 32, 4);
    testing::Append(packet, us, 4);
    testing::Append(packet, frame.size(), 4);
    testing::Append(packet, frame.size(), 4);
    AppendBlock(bytes, 6, packet + frame);
  }
  return bytes;
}

TEST(PcapRecording, ReadsPcapng) {
  const ReadResult result =
      ReadAll(*OpenCapture(WriteTestFile("a.pcapng", PcapngCapture({1, 1}))), 0);
  ASSERT_THAT(result.scans, SizeIs(2));
  EXPECT_EQ(result.scans[0].end_stamp_ns, kCaptureStart + VelodyneTimeNs({}, 74) + 1'306'368);
}

TEST(PcapRecording, InterfacesOfDifferentKindsAreNoDamage) {
  const auto recording = OpenPcapRecording(WriteTestFile("two.pcapng", PcapngCapture({1, 113})));
  const std::string message(recording.status().message());
  EXPECT_THAT(message, HasSubstr("interfaces of different kinds"));
  EXPECT_THAT(message, HasSubstr("not damaged"));
}

TEST(PcapRecording, TakesScansFromTo) {
  const auto recording = OpenCapture(WriteTestFile("a.pcap", VelodyneCapture({}, {}, 375)));
  const ReadResult all = ReadAll(*recording, 0);
  ASSERT_THAT(all.scans, SizeIs(5));
  ReadOptions options;
  options.from = 1;
  options.to = 3;
  const ReadResult some = ReadAll(*recording, 0, options);
  ASSERT_THAT(some.scans, SizeIs(3));
  EXPECT_EQ(some.scans[0].end_stamp_ns, all.scans[1].end_stamp_ns);
  EXPECT_EQ(some.scans[0].name, all.scans[1].name);
  options.to = 0;
  EXPECT_TRUE(absl::IsInvalidArgument(recording->OpenScans(0, options).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(recording->OpenScans(1, {}).status()));
}

TEST(PcapRecording, TellsSensorsApart) {
  CaptureWriter writer(Link::kEthernet);
  const VelodyneSource source;
  for (int i = 0; i < 80; ++i) {
    const int64_t arrival = kCaptureStart + VelodyneTimeNs(source, i);
    writer.Add({"10.0.0.1", 2368}, VelodynePacketOf(source, i, 0), arrival);
    writer.Add({"10.0.0.2", 2368}, VelodynePacketOf(source, i + 30, 0), arrival);
    writer.Add({"10.0.0.2", 2369}, VelodynePacketOf(source, i + 60, 0), arrival);
    writer.Add({"10.0.0.9", 53}, "something else", arrival);
  }
  const auto recording = OpenCapture(WriteTestFile("a.pcap", writer.bytes()));
  ASSERT_THAT(recording->scan_topics(), SizeIs(3));
  EXPECT_THAT(recording->notes(), Contains(HasSubstr("80 datagrams are no points")));
  const ReadResult first = ReadAll(*recording, 0), second = ReadAll(*recording, 1);
  EXPECT_EQ(first.scans.at(0).payload.width, 75u * 12 * 32);
  EXPECT_EQ(second.scans.at(0).payload.width, 45u * 12 * 32);
}

OusterSource LargeOuster() {
  OusterSource source;
  source.rows = 128;
  source.columns = 512;
  source.column_ns = 195'312;
  source.start_ns = kCaptureStart;
  return source;
}

std::string OusterCapture(size_t mtu, const char* address, int lost_fragment = -1) {
  CaptureWriter writer(Link::kEthernet);
  OusterSource source = LargeOuster();
  int frames = 0;
  for (; source.frame <= 2; ++source.frame) {
    for (int column = 0; column < source.columns; column += 16) {
      const int64_t arrival =
          static_cast<int64_t>(source.start_ns) + 195'312 * (column + 15) + 100'000;
      for (const std::string& frame : testing::Frames(Link::kEthernet, {address, 7502},
                                                      testing::OusterPacket(source, column), mtu)) {
        if (frames++ != lost_fragment) writer.Add(frame, arrival);
      }
    }
    source.start_ns += 100'000'000;
  }
  return writer.bytes();
}

TEST(PcapRecording, PutsFragmentsTogether) {
  for (const char* address : {"192.168.1.201", "fe80::1"}) {
    const std::string path = WriteTestFile("os.pcap", OusterCapture(1500, address));
    WriteTestFile("os.json", testing::OusterMetadata(LargeOuster(), true));
    const auto recording = OpenCapture(path);
    ASSERT_THAT(recording->scan_topics(), SizeIs(1));
    EXPECT_EQ(recording->scan_topics()[0].type, "Ouster packets");
    EXPECT_EQ(recording->scan_topics()[0].messages, 64u);
    const ReadResult result = ReadAll(*recording, 0);
    ASSERT_THAT(result.scans, SizeIs(2));
    EXPECT_THAT(result.errors, IsEmpty());
    EXPECT_EQ(result.scans[1].payload.width, 512u * 128);
    EXPECT_EQ(result.scans[1].end_stamp_ns, kCaptureStart + 100'000'000 + 511 * 195'312);
  }
}

TEST(PcapRecording, SaysThatFragmentsAreMissing) {
  const std::string path = WriteTestFile("os.pcap", OusterCapture(1500, "10.0.0.1", 20));
  WriteTestFile("os.json", testing::OusterMetadata(LargeOuster(), false));
  const ReadResult result = ReadAll(*OpenCapture(path), 0);
  ASSERT_THAT(result.scans, SizeIs(2));
  EXPECT_LT(result.scans[0].payload.width, 512u * 128);
  ASSERT_THAT(result.errors, SizeIs(1));
  EXPECT_THAT(result.errors[0], HasSubstr("missing fragments"));
}

TEST(PcapRecording, FindsMetadata) {
  const std::string path = WriteTestFile("os.pcap", OusterCapture(9000, "10.0.0.1"));
  const auto recording = OpenCapture(path);
  const auto refused = recording->OpenScans(0, {});
  EXPECT_TRUE(absl::IsInvalidArgument(refused.status()));
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("os.json"));
  ReadOptions options;
  options.metadata = "/nowhere/metadata.json";
  EXPECT_TRUE(absl::IsNotFound(recording->OpenScans(0, options).status()));
  // Neither of these is the sensor's; the third one is.
  OusterSource small;
  WriteTestFile("digest.json", "{\"scans\": []}");
  WriteTestFile("small.json", testing::OusterMetadata(small, false));
  EXPECT_FALSE(recording->OpenScans(0, {}).ok());
  const std::string named =
      WriteTestFile("large.json", testing::OusterMetadata(LargeOuster(), false));
  EXPECT_THAT(ReadAll(*recording, 0).scans, SizeIs(2));
  // Another one that fits makes a choice of it.
  WriteTestFile("larger.json", testing::OusterMetadata(LargeOuster(), true));
  EXPECT_THAT(std::string(recording->OpenScans(0, {}).status().message()), HasSubstr("several"));
  options.metadata = named;
  EXPECT_THAT(ReadAll(*recording, 0, options).scans, SizeIs(2));
  options.metadata = WriteTestFile("broken.json", "{");
  EXPECT_THAT(std::string(recording->OpenScans(0, options).status().message()),
              HasSubstr("broken.json"));
}

TEST(PcapRecording, ReadsDamagedFilesAsFarAsTheyGo) {
  const std::string whole = VelodyneCapture(Link::kEthernet, {}, 160);
  // Cut in a packet; a length that lies.
  std::string lies = whole;
  const size_t record = 16 + 42 + 1206;
  lies.replace(24 + 100 * record + 8, 4, "\xFF\xFF\xFF\x7F");
  for (const std::string& bytes : {whole.substr(0, 24 + 100 * record + 500), lies}) {
    const auto recording = OpenCapture(WriteTestFile("a.pcap", bytes));
    EXPECT_THAT(recording->notes(), Contains(HasSubstr("damaged behind 100 packets")));
    const ReadResult result = ReadAll(*recording, 0);
    EXPECT_THAT(result.scans, SizeIs(2));
    ASSERT_THAT(result.errors, SizeIs(1));
    EXPECT_THAT(result.errors[0], HasSubstr("bytes were skipped"));
  }
}

TEST(PcapRecording, SaysThatPacketsWereCut) {
  CaptureWriter writer(Link::kEthernet);
  std::string bytes = VelodyneCapture(Link::kEthernet, {}, 80);
  std::string frame = testing::Frames(Link::kEthernet, {}, VelodynePacketOf({}, 80, 0)).at(0);
  testing::Append(bytes, 0, 8);
  testing::Append(bytes, 200, 4);
  testing::Append(bytes, frame.size(), 4);
  bytes += frame.substr(0, 200);
  const ReadResult result = ReadAll(*OpenCapture(WriteTestFile("a.pcap", bytes)), 0);
  EXPECT_THAT(result.scans, SizeIs(2));
  ASSERT_THAT(result.errors, SizeIs(1));
  EXPECT_THAT(result.errors[0], HasSubstr("1 packets that the capture cut short"));
}

TEST(PcapRecording, SkipsForeignPacketsOfTheSensorsPort) {
  CaptureWriter writer(Link::kEthernet);
  for (int i = 0; i < 80; ++i) {
    const int64_t arrival = kCaptureStart + VelodyneTimeNs({}, i);
    writer.Add({}, VelodynePacketOf({}, i, 0), arrival);
    if (i % 10 == 0) writer.Add({}, "hello", arrival);
  }
  const ReadResult result = ReadAll(*OpenCapture(WriteTestFile("a.pcap", writer.bytes())), 0);
  EXPECT_THAT(result.scans, SizeIs(2));
  ASSERT_THAT(result.errors, SizeIs(1));
  EXPECT_THAT(result.errors[0], HasSubstr("8 packets of udp 2368"));
}

TEST(PcapRecording, RefusesWhatIsNoCapture) {
  EXPECT_TRUE(absl::IsNotFound(OpenPcapRecording("/nowhere/a.pcap").status()));
  EXPECT_TRUE(absl::IsInvalidArgument(OpenPcapRecording(WriteTestFile("a", "text")).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(OpenPcapRecording(WriteTestFile("b", "")).status()));
  CaptureWriter empty(Link::kEthernet);
  EXPECT_TRUE(absl::IsNotFound(OpenPcapRecording(WriteTestFile("c", empty.bytes())).status()));
  std::string bluetooth = empty.bytes();
  bluetooth[20] = static_cast<char>(201);
  const auto refused = OpenPcapRecording(WriteTestFile("d", bluetooth));
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("link"));
}

TEST(PcapRecording, LyingSizesInFramesAreNoDatagrams) {
  CaptureWriter writer(Link::kEthernet);
  const std::string good = testing::Frames(Link::kEthernet, {}, VelodynePacketOf({}, 0, 0)).at(0);
  for (size_t at = 12; at < 42; ++at) {
    for (const char value : {'\0', '\x7F', '\xFF'}) {
      std::string bad = good;
      bad[at] = value;
      writer.Add(bad, kCaptureStart);
    }
  }
  for (size_t size = 0; size < 60; ++size) writer.Add(good.substr(0, size), kCaptureStart);
  writer.Add(good, kCaptureStart);
  const auto recording = OpenCapture(WriteTestFile("a.pcap", writer.bytes()));
  for (size_t topic = 0; topic < recording->scan_topics().size(); ++topic) {
    ReadAll(*recording, topic);
  }
}

TEST(PcapRecording, ReadsFixesAndBelievesTheirClock) {
  CaptureWriter writer(Link::kEthernet);
  const VelodyneSource source;
  // The host is 700 s ahead of UTC; the hour began at 22:00 on 2023-11-14.
  const int64_t ahead = 700'000'000'000;
  for (int i = 0; i < 1600; ++i) {
    const int64_t arrival = kCaptureStart + VelodyneTimeNs(source, i) + ahead;
    writer.Add({"10.0.0.1", 2368}, VelodynePacketOf(source, i, 0), arrival);
    if (i % 100 != 0) continue;
    const int64_t us = VelodyneTimeNs(source, i) / 1000;
    const std::string sentence = "GPRMC,22000" + std::to_string(us / 1'000'000) + ".00," +
                                 (i < 200 ? "V" : "A") +
                                 ",4807.038,N,01131.000,E,000.0,000.0,141123,003.1,W";
    writer.Add({"10.0.0.1", 8308}, testing::PositionPacketOf(static_cast<uint32_t>(us), sentence),
               arrival);
  }
  const auto recording = OpenCapture(WriteTestFile("a.pcap", writer.bytes()));
  ASSERT_THAT(recording->gnss_topics(), SizeIs(1));
  EXPECT_EQ(recording->gnss_topics()[0].name, "udp 8308 from 10.0.0.1");
  const auto fixes = recording->ReadFixes(0);
  ASSERT_TRUE(fixes.ok());
  ASSERT_THAT(*fixes, SizeIs(2));  // Each second once.
  EXPECT_EQ((*fixes)[1].stamp_ns, kCaptureStart + 1'000'000'000);
  EXPECT_NEAR((*fixes)[0].latitude_deg, 48 + 7.038 / 60, 1e-9);
  EXPECT_EQ((*fixes)[0].altitude_m, 0);
  EXPECT_EQ((*fixes)[0].sigma_up_m, 0);
  EXPECT_TRUE(absl::IsInvalidArgument(recording->ReadFixes(1).status()));
  const ReadResult result = ReadAll(*recording, 0);
  EXPECT_EQ(result.scans.at(0).end_stamp_ns,
            kCaptureStart + VelodyneTimeNs(source, 74) + 1'306'368);
  EXPECT_THAT(result.assumptions, Contains(HasSubstr("GNSS")));
}

TEST(PcapRecording, RefusesAnHdl64WithoutItsCalibrationAtOnce) {
  CaptureWriter writer(Link::kEthernet);
  VelodyneSource source;
  source.two_banks = true;
  source.blocks_per_firing = 2;
  writer.Add({}, VelodynePacketOf(source, 0, 0), kCaptureStart);
  const auto recording = OpenCapture(WriteTestFile("a.pcap", writer.bytes()));
  EXPECT_TRUE(absl::IsInvalidArgument(recording->OpenScans(0, {}).status()));
  ReadOptions options;
  options.calibration = "/nowhere/a.yaml";
  EXPECT_TRUE(absl::IsNotFound(recording->OpenScans(0, options).status()));
  options.calibration = WriteTestFile("a.yaml", "lasers: [{laser_id: 0}]");
  EXPECT_TRUE(absl::IsInvalidArgument(recording->OpenScans(0, options).status()));
}

}  // namespace
}  // namespace isthmus::readers
