#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "client/readers/packets/maker.h"
#include "client/readers/packets/packet_decoder.h"
#include "core/codec/payload_layout.h"
#include "core/geometry/angles.h"
#include "tests/client/readers/packets/packet_writer.h"

namespace isthmus::readers {
namespace {

using testing::Append;
using ::testing::Contains;
using ::testing::HasSubstr;

// 2024-05-06 07:08:09.123456 UTC.
constexpr int64_t kStampNs = 1'714'979'289'123'456'000;

// A sensor's packets, by its manual.
struct HesaiSource {
  std::string name;
  int lasers, blocks;
  std::string header;  // The packet's.
  std::string flag;    // Each block's.
  size_t unit_bytes;   // A measurement's.
  size_t behind;       // Bytes between the blocks and the tail.
  size_t tail_bytes;   // Offsets in the tail follow.
  size_t mode, date, microseconds;
  int years_from;
  size_t bytes;  // The packet's.
  // Nanoseconds from the packet's time to the firing of the first and the last laser of the first
  // and of the last block, each return alone.
  int64_t first_ns, last_ns;
};

const HesaiSource kHesaiSources[] = {
    {"Pandar40P", 40, 10, "", "\xFF\xEE", 3, 0, 22, 14, 16, 10, 2000, 1262,
     -28580 - 9 * 55560 - 42220, -28580 - 3620},
    {"Pandar64", 64, 6, std::string("\xEE\xFF\x40\x06\0\x04\0\0", 8), "", 3, 0, 22, 14, 16, 10,
     2000, 1194, -42580 - 5 * 55560 - 23180, -42580 - 12748},
    {"PandarQT64", 64, 4, std::string("\xEE\xFF\x03\x01\0\0\x40\x04\0\x04\x01\0", 12), "", 4, 0, 24,
     16, 18, 12, 1900, 1068, 25710 + 12310, 25710 + 500000 + 146450},
    {"PandarXT16", 16, 8, std::string("\xEE\xFF\x06\x01\0\0\x10\x08\x01\x04\x01\x01", 12), "", 4, 0,
     24, 10, 13, 19, 1900, 564, 5632 - 7 * 50000 + 368, 5632 + 368 + 15 * 3024},
    {"PandarXT32", 32, 8, std::string("\xEE\xFF\x06\x01\0\0\x20\x08\x01\x04\x01\x01", 12), "", 4, 0,
     24, 10, 13, 19, 1900, 1076, 5632 - 7 * 50000 + 368, 5632 + 368 + 31 * 1512},
    {"PandarXT32M", 32, 6, std::string("\xEE\xFF\x06\x01\0\0\x20\x06\x01\x04\x01\x01", 12), "", 4,
     0, 24, 10, 13, 19, 1900, 816, 5632 - 5 * 50000 + 368, 5632 + 368 + 15 * 2888},
    {"PandarQT128", 128, 2, std::string("\xEE\xFF\x03\x02\0\0\x80\x02\x01\x04\x01\x14", 12), "", 4,
     21, 26, 12, 15, 21, 1900, 1087, 9000 - 111110, 9000 + 48976},
    {"OT128", 128, 2, std::string("\xEE\xFF\x01\x04\0\0\x80\x02\x01\x04\x01\x04", 12), "", 3, 21,
     26, 12, 15, 21, 1900, 831, 43346 - 55556 + 49758, 43346 + 30156},
};

double ElevationOf(int laser) { return 10.25 - 0.5 * laser; }
double AzimuthOf(int laser) { return 1.5 - 0.125 * (laser % 16); }
uint16_t RangeOf(int block, int laser) { return static_cast<uint16_t>(2000 + 100 * block + laser); }

std::string HesaiAngles(const HesaiSource& source) {
  std::string csv = "Laser id,Elevation,Azimuth\n";
  for (int i = 0; i < source.lasers; ++i) {
    absl::StrAppend(&csv, i + 1, ",", ElevationOf(i), ",", AzimuthOf(i), "\r\n");
  }
  return csv;
}

// `azimuth` of the first block, hundredths of a degree, of which each turns 20 on.
std::string HesaiPacket(const HesaiSource& source, int azimuth, int returns = 1,
                        std::optional<uint16_t> range = std::nullopt) {
  std::string bytes = source.header;
  for (int block = 0; block < source.blocks; ++block) {
    bytes += source.flag;
    Append(bytes, static_cast<uint64_t>((azimuth + 20 * (block / returns)) % 36000), 2);
    for (int laser = 0; laser < source.lasers; ++laser) {
      Append(bytes, range.value_or(RangeOf(block, laser)), 2);
      Append(bytes, static_cast<uint64_t>(laser), static_cast<int>(source.unit_bytes) - 2);
    }
  }
  bytes.append(source.behind, '\0');
  std::string tail(source.tail_bytes, '\0');
  tail[source.mode] = returns == 2 ? '\x39' : '\x37';
  const int date[] = {2024 - source.years_from, 5, 6, 7, 8, 9};
  for (size_t i = 0; i < 6; ++i) tail[source.date + i] = static_cast<char>(date[i]);
  std::string microseconds;
  Append(microseconds, 123456, 4);
  if (source.name == "OT128") tail[11] = '\x02';  // The standard mode.
  return bytes + tail.replace(source.microseconds, 4, microseconds);
}

std::unique_ptr<PacketDecoder> MakeFor(const HesaiSource& source) {
  absl::StatusOr<std::unique_ptr<PacketDecoder>> decoder =
      MakeHesaiDecoder({.calibration = HesaiAngles(source)});
  EXPECT_TRUE(decoder.ok()) << decoder.status();
  return *std::move(decoder);
}

std::vector<RecordedScan> DecodeAll(PacketDecoder& decoder,
                                    const std::vector<std::string>& packets) {
  std::vector<RecordedScan> scans;
  for (const std::string& packet : packets) {
    const absl::Status status = decoder.Add(packet, kStampNs + 1'000'000, &scans);
    EXPECT_TRUE(status.ok()) << status;
  }
  decoder.Flush(&scans);
  return scans;
}

std::vector<double> ColumnOf(const RecordedScan& scan, const char* name) {
  return codec::ReadColumn(scan.payload, *codec::FindField(scan.payload, {name}));
}

class HesaiDecoder : public ::testing::TestWithParam<HesaiSource> {};

TEST_P(HesaiDecoder, PutsPointsWhereTheManualDoes) {
  const HesaiSource& source = GetParam();
  ASSERT_EQ(HesaiPacket(source, 9000).size(), source.bytes);
  const auto decoder = MakeFor(source);
  const std::vector<RecordedScan> scans = DecodeAll(*decoder, {HesaiPacket(source, 9000)});
  ASSERT_EQ(scans.size(), 1u);
  const std::vector<double> x = ColumnOf(scans[0], "x"), y = ColumnOf(scans[0], "y"),
                            z = ColumnOf(scans[0], "z"), ring = ColumnOf(scans[0], "ring"),
                            intensity = ColumnOf(scans[0], "intensity");
  ASSERT_EQ(x.size(), static_cast<size_t>(source.blocks * source.lasers));
  for (size_t i = 0; i < x.size(); ++i) {
    const int block = static_cast<int>(i) / source.lasers,
              laser = static_cast<int>(i) % source.lasers;
    const double range = RangeOf(block, laser) * 0.004;
    const double azimuth = (90 + 0.2 * block + AzimuthOf(laser)) * kRadPerDeg;
    const double elevation = ElevationOf(laser) * kRadPerDeg;
    EXPECT_NEAR(x[i], range * std::cos(elevation) * std::sin(azimuth), 1e-4);
    EXPECT_NEAR(y[i], range * std::cos(elevation) * std::cos(azimuth), 1e-4);
    EXPECT_NEAR(z[i], range * std::sin(elevation), 1e-4);
    EXPECT_EQ(ring[i], source.lasers - 1 - laser);
    EXPECT_EQ(intensity[i], laser);
  }
}

TEST_P(HesaiDecoder, TimesPointsAsTheManualDoes) {
  const HesaiSource& source = GetParam();
  const auto decoder = MakeFor(source);
  const std::vector<RecordedScan> scans = DecodeAll(*decoder, {HesaiPacket(source, 9000)});
  const std::vector<double> time = ColumnOf(scans.at(0), "time");
  const auto offset_ns = [&](size_t point) {
    return static_cast<double>(scans[0].end_stamp_ns - kStampNs) + time[point] * 1e9;
  };
  EXPECT_NEAR(offset_ns(0), static_cast<double>(source.first_ns), 1);
  EXPECT_NEAR(offset_ns(time.size() - 1), static_cast<double>(source.last_ns), 1);
  EXPECT_THAT(decoder->Assumptions(), Contains(HasSubstr("agrees with that of arrival")));
}

TEST_P(HesaiDecoder, OfTwoReturnsBothArePointsWhereTheyDiffer) {
  const HesaiSource& source = GetParam();
  const size_t all = static_cast<size_t>(source.blocks * source.lasers);
  const auto decoder = MakeFor(source);
  const std::vector<RecordedScan> scans = DecodeAll(*decoder, {HesaiPacket(source, 9000, 2)});
  const std::vector<double> time = ColumnOf(scans.at(0), "time");
  ASSERT_EQ(time.size(), all);
  EXPECT_EQ(time[0], time[static_cast<size_t>(source.lasers)]);
  EXPECT_THAT(decoder->Assumptions(), Contains(HasSubstr("both returns become points")));
  const std::vector<RecordedScan> same =
      DecodeAll(*MakeFor(source), {HesaiPacket(source, 9000, 2, 500)});
  EXPECT_EQ(same.at(0).payload.width, all / 2);
}

TEST_P(HesaiDecoder, AScanBeginsAtAzimuthZero) {
  const HesaiSource& source = GetParam();
  const auto decoder = MakeFor(source);
  EXPECT_EQ(DecodeAll(*decoder, {HesaiPacket(source, 35000), HesaiPacket(source, 35990),
                                 HesaiPacket(source, 300)})
                .size(),
            2u);
}

TEST_P(HesaiDecoder, IsToldByItsPackets) {
  const HesaiSource& source = GetParam();
  const std::string packet = HesaiPacket(source, 9000);
  EXPECT_EQ(MakerOf(packet, packet.size()), Maker::kHesai);
  const auto decoder =
      MakeHesaiDecoder({.sensor = source.name, .calibration = HesaiAngles(source)});
  ASSERT_TRUE(decoder.ok()) << decoder.status();
  EXPECT_EQ(DecodeAll(**decoder, {packet}).size(), 1u);
}

TEST_P(HesaiDecoder, RefusesWhatIsDamaged) {
  const HesaiSource& source = GetParam();
  const auto decoder = MakeFor(source);
  std::vector<RecordedScan> scans;
  const std::string good = HesaiPacket(source, 9000);
  std::string azimuth = good;
  azimuth[source.header.size() + source.flag.size() + 1] = '\xFF';
  for (const std::string& bad : {std::string(), good.substr(0, good.size() - 1), azimuth}) {
    EXPECT_TRUE(absl::IsInvalidArgument(decoder->Add(bad, 0, &scans)));
  }
  EXPECT_TRUE(scans.empty());
  EXPECT_TRUE(decoder->Add(good, INT64_MIN, &scans).ok());
  EXPECT_TRUE(decoder->Add(good, INT64_MAX, &scans).ok());
}

INSTANTIATE_TEST_SUITE_P(All, HesaiDecoder, ::testing::ValuesIn(kHesaiSources),
                         [](const auto& source) { return source.param.name; });

TEST(HesaiPackets, WithoutACalibrationTheNominalAnglesAreTaken) {
  for (const HesaiSource& source : kHesaiSources) {
    const auto decoder = MakeHesaiDecoder({});
    ASSERT_TRUE(decoder.ok());
    std::vector<RecordedScan> scans;
    const absl::Status status = (*decoder)->Add(HesaiPacket(source, 9000), kStampNs, &scans);
    const bool differ = absl::StrContains(source.name, "QT") || source.name == "OT128";
    EXPECT_EQ(absl::IsFailedPrecondition(status), differ) << status;
    if (differ) {
      EXPECT_THAT(std::string(status.message()), HasSubstr("give the CSV"));
      continue;
    }
    (*decoder)->Flush(&scans);
    const std::vector<double> ring = ColumnOf(scans.at(0), "ring");
    EXPECT_EQ(ring[0], source.lasers - 1);
    EXPECT_EQ(ring[static_cast<size_t>(source.lasers) - 1], 0);
  }
}

TEST(HesaiPackets, TheLoopsOfAQt128FireInTheirOwnOrder) {
  const HesaiSource& source = kHesaiSources[6];
  ASSERT_EQ(source.name, "PandarQT128");
  const std::vector<RecordedScan> scans = DecodeAll(*MakeFor(source), {HesaiPacket(source, 9000)});
  const std::vector<double> time = ColumnOf(scans.at(0), "time");
  const auto offset_ns = [&](size_t block, size_t laser) {
    return static_cast<double>(scans[0].end_stamp_ns - kStampNs) + time[128 * block + laser] * 1e9 -
           9000 + (block == 0 ? 111110 : 0);
  };
  const std::vector<std::pair<size_t, double>> first = {{32, 27656}, {35, 78344}, {64, 1456},
                                                        {67, 52144}, {96, 25944}, {127, 48120}};
  const std::vector<std::pair<size_t, double>> second = {
      {0, 2312}, {3, 53000}, {31, 24488}, {64, 600}, {67, 51288}, {96, 26800}, {127, 48976}};
  for (const auto& [laser, ns] : first) EXPECT_NEAR(offset_ns(0, laser), ns, 8) << laser;
  for (const auto& [laser, ns] : second) EXPECT_NEAR(offset_ns(1, laser), ns, 8) << laser;
}

TEST(HesaiPackets, SaysWhatItCannotRead) {
  const auto decoder = MakeHesaiDecoder({});
  std::vector<RecordedScan> scans;
  std::string at128("\xEE\xFF\x04\x03\0\0\x80\x02\x01\x04\x01\x04", 12);
  at128.resize(1118);
  EXPECT_THAT(std::string((*decoder)->Add(at128, 0, &scans).message()), HasSubstr("protocol 4.3"));
  EXPECT_THAT(std::string(MakeHesaiDecoder({.sensor = "hal9000"}).status().message()),
              HasSubstr("Pandar64, QT64"));
  for (const char* csv : {"1,0,0\n", "1,0,0\n1,0,0\n", "1,95,0\n", "0,0,0\n", "x"}) {
    EXPECT_TRUE(
        absl::IsInvalidArgument(MakeHesaiDecoder({.sensor = "XT16", .calibration = csv}).status()));
  }
  EXPECT_TRUE(absl::IsFailedPrecondition(
      (*MakeHesaiDecoder({.sensor = "XT16"}))->Add(HesaiPacket(kHesaiSources[0], 0), 0, &scans)));
}

}  // namespace
}  // namespace isthmus::readers
