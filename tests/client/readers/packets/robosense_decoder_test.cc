#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "client/readers/packets/maker.h"
#include "client/readers/packets/packet_decoder.h"
#include "client/readers/packets/pcap_recording.h"
#include "core/codec/payload_layout.h"
#include "core/geometry/angles.h"
#include "tests/client/readers/packets/packet_writer.h"

namespace isthmus::readers {
namespace {

using testing::AppendBig;
using ::testing::Contains;
using ::testing::HasSubstr;

// 2024-05-06 07:08:09.123456 UTC.
constexpr int64_t kRobosenseNs = 1'714'979'289'123'456'000;

// A sensor's packets, by its manual.
struct RobosenseSource {
  std::string name;
  int lasers, blocks, channels;
  bool old_id, ruby;
  double unit_m, lens_m;
  double block_us;                // From block to block.
  double angle_unit;              // Degrees, of DIFOP.
  std::vector<double> firing_us;  // The first channels'.
  double last_us;                 // The last channel's.
};

const RobosenseSource kRobosense[] = {
    {"RS16", 16, 12, 32, true, false, 0.005, 0.03825, 111, 1e-4, {0, 2.8, 5.6}, 55.5 + 15 * 2.8},
    {"RS32", 32, 12, 32, true, false, 0.005, 0.03997, 55.52, 1e-3, {0, 2.88, 5.76}, 46.08},
    {"Helios16", 16, 12, 32, false, false, 0.0025, 0.03498, 111.12, 1e-2, {0, 1.73}, 31 * 1.73},
    {"Helios32", 32, 12, 32, false, false, 0.0025, 0.03498, 55.56, 1e-2, {0, 1.73}, 31 * 1.73},
    {"Ruby80", 80, 4, 80, false, true, 0.005, 0.03615, 55.552, 1e-2, {0, 0, 0, 3.236}, 48.54},
    {"Ruby128", 128, 3, 128, false, true, 0.005, 0.03615, 55.55, 1e-2, {0, 0, 0, 0, 3.236}, 48.54},
};

// The lower half of an RS-LiDAR-16 comes first, and looks down.
double RobosenseElevation(const RobosenseSource& source, int laser) {
  if (source.name == "RS16") return laser < 8 ? -15 + 2 * laser : 31 - 2 * laser;
  return -20 + 0.25 * laser;
}
double RobosenseAzimuth(const RobosenseSource& source, int laser) {
  return source.name == "RS16" ? 0 : 2 - 0.5 * (laser % 8);
}
int RobosenseRange(int block, int channel) { return 2000 + 50 * block + channel; }

std::string RobosenseDifop(const RobosenseSource& source, bool both = false) {
  std::string bytes("\xA5\xFF\x00\x5A\x11\x11\x55\x55", 8);
  bytes.resize(1248);
  bytes[300] = static_cast<char>(both ? (source.ruby ? 3 : 0) : 1);
  const auto put = [&](size_t at, double degrees) {
    std::string angle(1, degrees < 0 ? '\x01' : '\0');
    AppendBig(angle, static_cast<uint64_t>(std::llround(std::abs(degrees) / source.angle_unit)), 2);
    bytes.replace(at, 3, angle);
  };
  const int rows = source.lasers <= 32 ? 32 : 128;
  for (int i = 0; i < rows; ++i) {
    if (source.name == "RS16") break;
    bytes[468 + 3 * static_cast<size_t>(i)] = '\xFF';
  }
  for (int i = 0; i < source.lasers; ++i) {
    const size_t at = static_cast<size_t>(i) * 3;
    if (source.name == "RS16") {
      std::string angle;
      AppendBig(angle, std::llround(std::abs(RobosenseElevation(source, i)) * 1e4), 3);
      bytes.replace(1165 + at, 3, angle);
      continue;
    }
    put(468 + at, RobosenseElevation(source, i));
    put(468 + 3 * static_cast<size_t>(rows) + at, RobosenseAzimuth(source, i));
  }
  return bytes;
}

// `azimuth` of the first block, of which each turns 20 on; with `same` two share each.
std::string RobosensePacket(const RobosenseSource& source, int azimuth, bool same = false,
                            bool nanoseconds = false) {
  std::string bytes = source.old_id ? std::string("\x55\xAA\x05\x0A\x5A\xA5\x50\xA0", 8)
                                    : std::string("\x55\xAA\x05\x5A", 4);
  bytes.resize(source.ruby ? 10 : 20);
  if (source.old_id) {
    bytes += std::string("\x18\x05\x06\x07\x08\x09", 6);
    AppendBig(bytes, 123, 2);
    AppendBig(bytes, 456, 2);
  } else {
    AppendBig(bytes, kRobosenseNs / 1'000'000'000, 6);
    AppendBig(bytes, nanoseconds ? 123'456'000 : 123'456, 4);
  }
  bytes.resize(source.ruby ? 80 : 42);
  bytes[30] = source.name == "RS16" ? '\x01' : '\x02';
  for (int block = 0; block < source.blocks; ++block) {
    AppendBig(bytes, source.ruby ? 0xFE01 : 0xFFEE, 2);
    AppendBig(bytes, (azimuth + 20 * (same ? block / 2 : block)) % 36000, 2);
    for (int channel = 0; channel < source.channels; ++channel) {
      AppendBig(bytes, RobosenseRange(block, channel), 2);
      AppendBig(bytes, channel, 1);
    }
  }
  bytes.resize(1248);
  return bytes;
}

std::vector<RecordedScan> DecodeRobosense(PacketDecoder& decoder,
                                          const std::vector<std::string>& packets) {
  std::vector<RecordedScan> scans;
  for (const std::string& packet : packets) {
    const absl::Status status = decoder.Add(packet, kRobosenseNs + 1'000'000, &scans);
    EXPECT_TRUE(status.ok()) << status;
  }
  decoder.Flush(&scans);
  return scans;
}

std::vector<double> RobosenseColumn(const RecordedScan& scan, const char* name) {
  return codec::ReadColumn(scan.payload, *codec::FindField(scan.payload, {name}));
}

class RobosenseDecoder : public ::testing::TestWithParam<RobosenseSource> {};

TEST_P(RobosenseDecoder, PutsPointsWhereTheManualDoes) {
  const RobosenseSource& source = GetParam();
  const auto decoder = *MakeRobosenseDecoder({});
  const std::vector<RecordedScan> scans =
      DecodeRobosense(*decoder, {RobosenseDifop(source), RobosensePacket(source, 9000)});
  ASSERT_EQ(scans.size(), 1u);
  const auto x = RobosenseColumn(scans[0], "x"), y = RobosenseColumn(scans[0], "y"),
             z = RobosenseColumn(scans[0], "z"), time = RobosenseColumn(scans[0], "time"),
             ring = RobosenseColumn(scans[0], "ring");
  ASSERT_EQ(x.size(), static_cast<size_t>(source.blocks * source.channels));
  const double start_s = time[0];
  for (size_t i = 0; i < x.size(); ++i) {
    const int block = static_cast<int>(i) / source.channels;
    const int channel = static_cast<int>(i) % source.channels, laser = channel % source.lasers;
    // The sensor turns 0.2 degrees in each block's time.
    const double after_us = (time[i] - start_s) * 1e6;
    const double turned = (90 + 0.2 * after_us / source.block_us) * kRadPerDeg;
    const double azimuth = turned + RobosenseAzimuth(source, laser) * kRadPerDeg;
    const double elevation = RobosenseElevation(source, laser) * kRadPerDeg;
    const double range = RobosenseRange(block, channel) * source.unit_m;
    EXPECT_NEAR(x[i],
                range * std::cos(elevation) * std::cos(azimuth) + source.lens_m * std::cos(turned),
                1e-4);
    EXPECT_NEAR(y[i],
                -range * std::cos(elevation) * std::sin(azimuth) - source.lens_m * std::sin(turned),
                1e-4);
    EXPECT_NEAR(z[i], range * std::sin(elevation), 1e-4);
    EXPECT_TRUE(ring[i] == laser || source.name == "RS16") << i;
  }
}

TEST_P(RobosenseDecoder, TimesPointsAsTheManualDoes) {
  const RobosenseSource& source = GetParam();
  const auto decoder = *MakeRobosenseDecoder({});
  const std::vector<RecordedScan> scans =
      DecodeRobosense(*decoder, {RobosenseDifop(source), RobosensePacket(source, 9000)});
  const auto time = RobosenseColumn(scans.at(0), "time");
  const auto offset_us = [&](size_t i) {
    return static_cast<double>(scans[0].end_stamp_ns - kRobosenseNs) * 1e-3 + time[i] * 1e6;
  };
  for (size_t i = 0; i < source.firing_us.size(); ++i) {
    EXPECT_NEAR(offset_us(i), source.firing_us[i], 2e-3);
    EXPECT_NEAR(offset_us(static_cast<size_t>(source.channels) + i),
                source.block_us + source.firing_us[i], 2e-3);
  }
  EXPECT_NEAR(offset_us(time.size() - 1), (source.blocks - 1) * source.block_us + source.last_us,
              2e-3);
  EXPECT_THAT(decoder->Assumptions(), Contains(HasSubstr("agrees with that of arrival")));
}

TEST_P(RobosenseDecoder, BlocksOfOneAzimuthAreReturnsOfOneFiring) {
  const RobosenseSource& source = GetParam();
  const auto decoder = *MakeRobosenseDecoder({});
  const std::vector<RecordedScan> scans = DecodeRobosense(
      *decoder, {RobosenseDifop(source, true), RobosensePacket(source, 9000, true)});
  const auto time = RobosenseColumn(scans.at(0), "time");
  ASSERT_EQ(time.size(), static_cast<size_t>(source.blocks * source.channels));
  EXPECT_EQ(time[0], time[static_cast<size_t>(source.channels)]);
}

TEST_P(RobosenseDecoder, TakesAnglesOfAFileBeforeThoseOfTheSensor) {
  const RobosenseSource& source = GetParam();
  std::string csv;
  for (int i = 0; i < source.lasers; ++i) absl::StrAppend(&csv, -0.5 * i, ",0\n");
  const auto decoder = *MakeRobosenseDecoder({.calibration = csv});
  const std::vector<RecordedScan> scans =
      DecodeRobosense(*decoder, {RobosenseDifop(source), RobosensePacket(source, 9000)});
  EXPECT_NEAR(RobosenseColumn(scans.at(0), "z").at(0), 0, 1e-6);
  EXPECT_EQ(RobosenseColumn(scans[0], "ring").at(0), source.lasers - 1);
  EXPECT_THAT(decoder->Assumptions(), Contains(HasSubstr("the calibration that was given")));
}

TEST_P(RobosenseDecoder, AScanBeginsAtAzimuthZero) {
  const RobosenseSource& source = GetParam();
  const auto decoder = *MakeRobosenseDecoder({});
  EXPECT_EQ(
      DecodeRobosense(*decoder, {RobosenseDifop(source), RobosensePacket(source, 35000),
                                 RobosensePacket(source, 35990), RobosensePacket(source, 300)})
          .size(),
      2u);
}

TEST_P(RobosenseDecoder, IsReadFromACaptureOfBothItsPorts) {
  const RobosenseSource& source = GetParam();
  testing::CaptureWriter writer(testing::Link::kEthernet);
  for (int i = 0; i < 3; ++i) {
    writer.Add({"192.168.1.200", 6699}, RobosensePacket(source, 9000 + i * 20 * source.blocks),
               kRobosenseNs + i * 1'000'000);
  }
  writer.Add({"192.168.1.200", 7788}, RobosenseDifop(source), kRobosenseNs + 4'000'000);
  const auto recording =
      OpenPcapRecording(testing::WriteTestFile("robosense.pcap", writer.bytes()));
  ASSERT_TRUE(recording.ok()) << recording.status();
  EXPECT_EQ((*recording)->scan_topics().at(0).type, "RoboSense packets");
  EXPECT_TRUE((*recording)->notes().empty());
  const auto reader = (*recording)->OpenScans(0, {});
  ASSERT_TRUE(reader.ok()) << reader.status();
  const auto scan = (*reader)->Next();
  ASSERT_TRUE(scan.ok() && scan->has_value()) << scan.status();
  EXPECT_EQ((*scan)->payload.width, static_cast<uint32_t>(3 * source.blocks * source.channels));
}

TEST_P(RobosenseDecoder, SaysWhatItNeeds) {
  const RobosenseSource& source = GetParam();
  const auto decoder = *MakeRobosenseDecoder({});
  std::vector<RecordedScan> scans;
  const absl::Status status = decoder->Add(RobosensePacket(source, 0), kRobosenseNs, &scans);
  EXPECT_EQ(status.ok(), source.name == "RS16") << status;
  EXPECT_TRUE(status.ok() || absl::StrContains(status.message(), "DIFOP")) << status;
}

INSTANTIATE_TEST_SUITE_P(All, RobosenseDecoder, ::testing::ValuesIn(kRobosense),
                         [](const auto& source) { return source.param.name; });

TEST(RobosensePackets, NewerOnesCountNanoseconds) {
  const RobosenseSource& source = kRobosense[5];
  const auto decoder = *MakeRobosenseDecoder({});
  const std::vector<RecordedScan> scans = DecodeRobosense(
      *decoder, {RobosenseDifop(source), RobosensePacket(source, 9000, false, true)});
  EXPECT_NEAR(static_cast<double>(scans.at(0).end_stamp_ns - kRobosenseNs), 2 * 55550 + 48540, 2);
}

TEST(RobosensePackets, OthersAreRefused) {
  const RobosenseSource& source = kRobosense[3];
  const auto decoder = *MakeRobosenseDecoder({});
  std::vector<RecordedScan> scans;
  EXPECT_TRUE(decoder->Add(RobosenseDifop(source), 0, &scans).ok());
  const std::string good = RobosensePacket(source, 9000);
  std::string azimuth = good, blocks = good;
  azimuth[44] = '\xFF';
  blocks[42] = '\0';
  for (const std::string& bad : {std::string(), good.substr(1), good + "x", azimuth, blocks}) {
    EXPECT_TRUE(absl::IsInvalidArgument(decoder->Add(bad, 0, &scans)));
  }
  EXPECT_TRUE(decoder->Add(good, INT64_MIN, &scans).ok());
  EXPECT_TRUE(decoder->Add(good, INT64_MAX, &scans).ok());
  EXPECT_EQ(MakerOf(good, good.size()), Maker::kRobosense);
}

}  // namespace
}  // namespace isthmus::readers
