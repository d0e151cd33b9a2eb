#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "client/readers/packets/packet_decoder.h"
#include "core/codec/payload_layout.h"
#include "core/codec/scan_decoder.h"
#include "floam/rings/sensor_model.h"
#include "tests/client/readers/packets/packet_writer.h"

namespace isthmus::readers {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::VelodynePacketOf;
using testing::VelodyneSource;
using testing::VelodyneTimeNs;

constexpr int64_t kVelodyneHour = 1'700'000'000LL / 3600 * 3600 * 1'000'000'000;
constexpr double kDeg = std::numbers::pi / 180;

struct Points {
  std::vector<double> x, y, z, intensity, ring, time;
};

Points PointsOf(const RecordedScan& scan) {
  EXPECT_TRUE(codec::CheckLayout(scan.payload).ok());
  Points points;
  const auto column = [&](const char* name) {
    const PointField* field = codec::FindField(scan.payload, {name});
    return field == nullptr ? std::vector<double>() : codec::ReadColumn(scan.payload, *field);
  };
  points.x = column("x");
  points.y = column("y");
  points.z = column("z");
  points.intensity = column("intensity");
  points.ring = column("ring");
  points.time = column("time");
  return points;
}

// Packets from..to of the sensor, which starts with the hour; they arrive `delay_ns` later.
std::vector<RecordedScan> Decode(PacketDecoder& decoder, const VelodyneSource& source, int from,
                                 int to, double start_us = 0, int64_t delay_ns = 0,
                                 bool flush = true) {
  std::vector<RecordedScan> scans;
  for (int i = from; i < to; ++i) {
    const int64_t arrival =
        kVelodyneHour + static_cast<int64_t>(start_us * 1e3) + VelodyneTimeNs(source, i) + delay_ns;
    const absl::Status status = decoder.Add(VelodynePacketOf(source, i, start_us), arrival, &scans);
    EXPECT_TRUE(status.ok()) << status;
  }
  if (flush) decoder.Flush(&scans);
  return scans;
}

std::unique_ptr<PacketDecoder> Make(const PacketOptions& options = {}) {
  absl::StatusOr<std::unique_ptr<PacketDecoder>> decoder = MakeVelodyneDecoder(options);
  EXPECT_TRUE(decoder.ok()) << decoder.status();
  return *std::move(decoder);
}

VelodyneSource Vlp16() { return {}; }
VelodyneSource Vlp16Dual() {
  VelodyneSource source;
  source.return_mode = 0x39;
  source.blocks_per_firing = 2;
  return source;
}
VelodyneSource Vlp32() {
  VelodyneSource source;
  source.product = 0x28;
  source.firing_us = 55.296;
  source.step = 20;
  return source;
}
VelodyneSource Hdl32() {
  VelodyneSource source;
  source.product = 0x21;
  source.firing_us = 46.08;
  source.step = 16;
  return source;
}
VelodyneSource Hdl64() {
  VelodyneSource source;
  source.product = 0x00;
  source.return_mode = 'V';
  source.two_banks = true;
  source.blocks_per_firing = 2;
  source.firing_us = 48;
  source.step = 18;
  return source;
}

// Two banks of 32, from -24 degrees up; all else 0.
std::string Hdl64Calibration() {
  std::string yaml = "num_lasers: 64\ndistance_resolution: 0.002\nlasers:\n";
  for (int i = 0; i < 64; ++i) {
    absl::StrAppend(&yaml, "- {laser_id: ", i,
                    ", rot_correction: 0.0, vert_correction: ", (-24.0 + 0.4 * i) * kDeg,
                    ", dist_correction: 0.0}\n");
  }
  return yaml;
}

TEST(VelodyneDecoder, TellsTheModel) {
  for (const auto& [source, name] :
       {std::pair(Vlp16(), "vlp16"), std::pair(Vlp32(), "vlp32"), std::pair(Hdl32(), "hdl32")}) {
    const auto decoder = Make();
    EXPECT_EQ(decoder->sensor(), "");
    Decode(*decoder, source, 0, 1);
    EXPECT_EQ(decoder->sensor(), name);
  }
}

TEST(VelodyneDecoder, PutsRingsWhereTheModelHasThem) {
  for (const auto& [source, unit] :
       {std::pair(Vlp16(), 0.002), std::pair(Vlp32(), 0.004), std::pair(Hdl32(), 0.002)}) {
    const auto decoder = Make();
    const std::vector<RecordedScan> scans = Decode(*decoder, source, 0, 3);
    ASSERT_EQ(scans.size(), 1u);
    const Points points = PointsOf(scans[0]);
    ASSERT_EQ(points.x.size(), 3u * 12 * 32);
    const auto model = floam::FindSensorModel(decoder->sensor());
    ASSERT_TRUE(model.ok());
    std::set<int> rings;
    for (size_t i = 0; i < points.x.size(); ++i) {
      const size_t ring = static_cast<size_t>(points.ring[i]);
      rings.insert(static_cast<int>(ring));
      ASSERT_LT(ring, model->elevations.size());
      const double ground = std::hypot(points.x[i], points.y[i]);
      EXPECT_NEAR(ground, 5000 * unit * std::cos(model->elevations[ring]), 5e-3);
      // The VLP-16 User Manual puts its lasers up to 11.2 mm above and below each other.
      EXPECT_NEAR(points.z[i], 5000 * unit * std::sin(model->elevations[ring]), 1.3e-2);
    }
    EXPECT_EQ(rings.size(), model->elevations.size());
  }
}

TEST(VelodyneDecoder, PutsLasersOfAVlp16AboveEachOther) {
  const auto decoder = Make();
  const Points points = PointsOf(Decode(*decoder, Vlp16(), 0, 1).at(0));
  // VLP-16 User Manual, table 9-1, lasers 0 and 15: 11.2 mm up and down.
  EXPECT_NEAR(points.z[0], 10 * std::sin(-15 * kDeg) + 0.0112, 1e-5);
  EXPECT_NEAR(points.z[15], 10 * std::sin(15 * kDeg) - 0.0112, 1e-5);
}

TEST(VelodyneDecoder, LooksForwardAtAzimuthZeroAndTurnsClockwise) {
  const auto decoder = Make();
  const std::vector<RecordedScan> scans = Decode(*decoder, Vlp16(), 0, 20);
  const Points points = PointsOf(scans.at(0));
  EXPECT_NEAR(points.x[0], 10 * std::cos(15 * kDeg), 1e-5);
  EXPECT_NEAR(points.y[0], 0, 1e-5);
  EXPECT_LT(points.y.back(), -1);  // To the right.
}

// Azimuth and time of a sensor that turns evenly say the same, whatever the laser.
void ExpectEvenTurn(const VelodyneSource& source, const PacketOptions& options,
                    const std::function<double(int ring)>& offset_deg) {
  const auto decoder = Make(options);
  const std::vector<RecordedScan> scans = Decode(*decoder, source, 0, 40);
  const Points points = PointsOf(scans.at(0));
  const double speed = source.step / 100.0 / (source.firing_us * 1e-6);
  const double first_s = points.time[0];
  for (size_t i = 0; i < points.x.size(); ++i) {
    const double azimuth = std::atan2(-points.y[i], points.x[i]) / kDeg;
    const double expected =
        (points.time[i] - first_s) * speed + offset_deg(static_cast<int>(points.ring[i])) -
        offset_deg(static_cast<int>(points.ring[0])) + std::atan2(-points.y[0], points.x[0]) / kDeg;
    // Packets are stamped to a microsecond, which is 0.004 degrees, and times are float32.
    ASSERT_NEAR(std::remainder(azimuth - expected, 360), 0, 0.006) << i;
  }
}

TEST(VelodyneDecoder, InterpolatesAzimuthsByTheTimesOfFirings) {
  const auto none = [](int) { return 0.0; };
  ExpectEvenTurn(Vlp16(), {}, none);
  ExpectEvenTurn(Vlp16Dual(), {}, none);
  ExpectEvenTurn(Hdl32(), {}, none);
  PacketOptions hdl64;
  hdl64.calibration = Hdl64Calibration();
  ExpectEvenTurn(Hdl64(), hdl64, none);
  // VLP-32C User Manual, table 9-6: the columns of the lasers, here by ring.
  const std::map<int, double> columns = {{0, 1.4},   {1, -1.4},  {14, 4.2}, {16, -1.4},
                                         {17, -4.2}, {29, -1.4}, {30, 1.4}, {31, -1.4}};
  const auto decoder = Make();
  const Points points = PointsOf(Decode(*decoder, Vlp32(), 0, 1).at(0));
  for (size_t i = 0; i < 32; ++i) {
    const auto column = columns.find(static_cast<int>(points.ring[i]));
    if (column == columns.end()) continue;
    const double behind = std::atan2(-points.y[i], points.x[i]) / kDeg - column->second;
    const size_t pair = i / 2;
    EXPECT_NEAR(behind, static_cast<double>(pair) * 2.304 / 55.296 * 0.20, 0.001) << i;
  }
}

TEST(VelodyneDecoder, TimesAreThoseOfTheManuals) {
  // The last measurement of a packet, microseconds behind the first.
  for (const auto& [source, last_us] :
       {std::pair(Vlp16(), 1306.368), std::pair(Vlp16Dual(), 642.816), std::pair(Vlp32(), 642.816),
        std::pair(Hdl32(), 542.592)}) {
    const auto decoder = Make();
    const std::vector<RecordedScan> scans = Decode(*decoder, source, 0, 1, 1234);
    const Points points = PointsOf(scans.at(0));
    EXPECT_NEAR(points.time[0], -last_us * 1e-6, 1e-9);
    EXPECT_EQ(points.time.back(), 0);
    EXPECT_EQ(scans[0].end_stamp_ns, kVelodyneHour + 1'234'000 + std::llround(last_us * 1e3));
  }
}

TEST(VelodyneDecoder, CutsWhereTheAzimuthPasses) {
  for (const double cut : {0.0, 90.0, 180.0, 359.9}) {
    PacketOptions options;
    options.cut_azimuth_deg = cut;
    const auto decoder = Make(options);
    // 900 blocks are a turn: 75 packets.
    const std::vector<RecordedScan> scans = Decode(*decoder, Vlp16(), 0, 300);
    // A block after 359.6 degrees is at 0 again.
    ASSERT_EQ(scans.size(), cut == 0 || cut > 359.6 ? 4u : 5u);
    for (size_t i = 1; i + 1 < scans.size(); ++i) {
      EXPECT_EQ(scans[i].payload.width, 900u * 32);
      const Points points = PointsOf(scans[i]);
      const double first = std::atan2(-points.y[0], points.x[0]) / kDeg;
      EXPECT_NEAR(std::remainder(first - cut, 360), 0.2, 0.21);
      // Packets are stamped to a microsecond.
      EXPECT_NEAR(static_cast<double>(scans[i].end_stamp_ns - scans[i - 1].end_stamp_ns),
                  75 * 1'327'104, 1001);
    }
    EXPECT_THAT(decoder->Assumptions(), Contains(HasSubstr("passes")));
  }
}

TEST(VelodyneDecoder, ScansAreUnderstoodByTheServer) {
  const auto decoder = Make();
  codec::ScanDecoder server;
  for (const RecordedScan& recorded : Decode(*decoder, Vlp16(), 0, 300)) {
    const auto scan = server.Decode(recorded.payload, 0, recorded.end_stamp_ns);
    ASSERT_TRUE(scan.ok()) << scan.status();
    EXPECT_TRUE(scan->has_time && scan->has_ring);
    EXPECT_EQ(scan->end_stamp_ns, recorded.end_stamp_ns);
    const Points points = PointsOf(recorded);
    ASSERT_EQ(scan->points.size(), points.x.size());
    EXPECT_NEAR(scan->points[0].time, points.time[0], 1e-6);
    EXPECT_EQ(scan->points[7].ring, points.ring[7]);
  }
}

TEST(VelodyneDecoder, KeepsBothReturnsInOrder) {
  VelodyneSource source = Vlp16Dual();
  // Lasers 0 to 9 see the same twice, 10 to 19 two things, 20 to 29 only a second one, others none.
  source.range = [](int, int laser, int which) -> uint16_t {
    if (laser >= 30) return 0;
    if (laser >= 20) return which == 1 ? 3000 : 0;
    return laser >= 10 && which == 1 ? 2000 : 5000;
  };
  const auto decoder = Make();
  const Points points = PointsOf(Decode(*decoder, source, 0, 1).at(0));
  ASSERT_EQ(points.x.size(), 6u * (20 + 20));
  EXPECT_NEAR(std::hypot(points.x[19], points.y[19], points.z[19]), 10, 0.02);
  EXPECT_NEAR(std::hypot(points.x[20], points.y[20], points.z[20]), 4, 0.02);  // Laser 10's second.
  EXPECT_NEAR(std::hypot(points.x[30], points.y[30], points.z[30]), 6, 0.02);
  EXPECT_EQ(points.intensity[20], 20);
  EXPECT_EQ(points.time[20], points.time[10]);  // The same firing.
  EXPECT_THAT(decoder->Assumptions(), Contains(HasSubstr("both returns become points")));
}

TEST(VelodyneDecoder, ReadsBothReturnsOfAnHdl64) {
  VelodyneSource source = Hdl64();
  source.blocks_per_firing = 4;
  source.firing_us = 57.6;
  source.range = [](int block, int laser, int which) -> uint16_t {
    return static_cast<uint16_t>(5000 + (laser % 2 == 0 ? which * 1000 : 0) + block % 2);
  };
  PacketOptions options;
  options.calibration = Hdl64Calibration();
  const auto decoder = Make(options);
  const Points points = PointsOf(Decode(*decoder, source, 0, 1).at(0));
  EXPECT_EQ(points.x.size(), 3u * (64 + 32));
  EXPECT_EQ(decoder->sensor(), "hdl64");
}

TEST(VelodyneDecoder, RefusesAnHdl64WithoutItsCalibration) {
  const auto decoder = Make();
  std::vector<RecordedScan> scans;
  const absl::Status status = decoder->Add(VelodynePacketOf(Hdl64(), 0, 0), 0, &scans);
  EXPECT_TRUE(absl::IsFailedPrecondition(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("give the YAML"));
  PacketOptions named;
  named.sensor = "HDL-64E";
  EXPECT_TRUE(absl::IsInvalidArgument(MakeVelodyneDecoder(named).status()));
  named.sensor = "vlp16";
  named.calibration = Hdl64Calibration();
  EXPECT_THAT(std::string(MakeVelodyneDecoder(named).status().message()), HasSubstr("64 lasers"));
  named.sensor = "livox";
  EXPECT_THAT(std::string(MakeVelodyneDecoder(named).status().message()), HasSubstr("vlp32"));
}

TEST(VelodyneDecoder, ClockPassesTheHour) {
  // The sensor's hour ends between two packets; those arrive a second late, or half a second early.
  for (const int64_t delay_ns : {int64_t{0}, int64_t{1'000'000'000}, int64_t{-500'000'000}}) {
    const auto decoder = Make();
    const VelodyneSource source = Vlp16();
    const double start_us = 3600e6 - 200e3;
    const std::vector<RecordedScan> scans = Decode(*decoder, source, 0, 300, start_us, delay_ns);
    ASSERT_EQ(scans.size(), 4u);
    for (size_t i = 0; i < scans.size(); ++i) {
      const int64_t first_ns = kVelodyneHour + 3'599'800'000'000;
      const int64_t last_packet = VelodyneTimeNs(source, static_cast<int>(75 * i + 74));
      EXPECT_EQ(scans[i].end_stamp_ns, first_ns + last_packet + 1'306'368) << delay_ns;
    }
    EXPECT_THAT(decoder->Assumptions(), Contains(HasSubstr("agrees")));
  }
}

TEST(VelodyneDecoder, PutsAFreeClockOnThatOfArrival) {
  // The sensor began to count 25 minutes ago; packets take 1 to 3 ms.
  const VelodyneSource source = Vlp16();
  for (const double start_us : {1500e6, 3599.9e6}) {
    const auto decoder = Make();
    std::vector<RecordedScan> scans;
    for (int i = 0; i < 150; ++i) {
      const int64_t arrival =
          kVelodyneHour + 60'000'000'000 + VelodyneTimeNs(source, i) + 1'000'000 * (1 + i % 3);
      ASSERT_TRUE(decoder->Add(VelodynePacketOf(source, i, start_us), arrival, &scans).ok());
    }
    decoder->Flush(&scans);
    ASSERT_EQ(scans.size(), 2u);
    EXPECT_EQ(scans[1].end_stamp_ns,
              kVelodyneHour + 60'000'000'000 + VelodyneTimeNs(source, 149) + 1'306'368 + 1'000'000);
    EXPECT_THAT(decoder->Assumptions(), Contains(HasSubstr("not synchronised")));
  }
}

TEST(VelodyneDecoder, BelievesAClockThatGnssSets) {
  PacketOptions options;
  options.utc_offset_ns = -600'000'000'000;  // The host is ten minutes ahead.
  const auto decoder = Make(options);
  const std::vector<RecordedScan> scans = Decode(*decoder, Vlp16(), 0, 1, 100e6, 600'400'000'000);
  EXPECT_EQ(scans.at(0).end_stamp_ns, kVelodyneHour + 100'000'000'000 + 1'306'368);
}

TEST(VelodyneDecoder, LostPacketsEndAScanWhereATurnMayBeMissing) {
  const auto decoder = Make();
  const VelodyneSource source = Vlp16();
  // A third of a turn is lost: one scan still, with times that are right.
  std::vector<RecordedScan> scans = Decode(*decoder, source, 0, 20, 0, 0, false);
  std::vector<RecordedScan> more = Decode(*decoder, source, 45, 75);
  ASSERT_TRUE(scans.empty());
  ASSERT_EQ(more.size(), 1u);
  EXPECT_NEAR(PointsOf(more[0]).time[0],
              -static_cast<double>(VelodyneTimeNs(source, 74) + 1'306'368) * 1e-9, 1e-6);
  // Two turns are: two scans.
  scans = Decode(*decoder, source, 0, 20, 0, 0, false);
  more = Decode(*decoder, source, 180, 190);
  EXPECT_EQ(more.size(), 2u);
}

TEST(VelodyneDecoder, CutsInTheDarkOfAFieldOfView) {
  // A quarter of each turn is seen, from 315 to 45 degrees; the cut is opposite.
  PacketOptions options;
  options.cut_azimuth_deg = 180;
  const auto decoder = Make(options);
  const VelodyneSource source = Vlp16();
  std::vector<RecordedScan> scans;
  for (int turn = 0; turn < 4; ++turn) {
    for (const RecordedScan& scan :
         Decode(*decoder, source, 75 * turn + 66, 75 * turn + 84, 0, 0, false)) {
      scans.push_back(scan);
    }
  }
  ASSERT_EQ(scans.size(), 3u);
  for (const RecordedScan& scan : scans) EXPECT_EQ(scan.payload.width, 18u * 12 * 32);
}

TEST(VelodyneDecoder, BoundsAScanOfASensorThatStandsStill) {
  VelodyneSource source = Vlp16();
  source.step = 0;
  const auto decoder = Make();
  // 0.5 s of packets at one azimuth.
  EXPECT_EQ(Decode(*decoder, source, 0, 400).size(), 2u);
  // And where the clock stands still, too.
  source.firing_us = 0;
  for (const RecordedScan& scan : Decode(*Make(), source, 0, 3000)) {
    EXPECT_LE(scan.payload.width, 1'000'000u);
  }
}

TEST(VelodyneDecoder, FlushAloneCutsMessages) {
  PacketOptions options;
  options.by_flush = true;
  const auto decoder = Make(options);
  EXPECT_EQ(Decode(*decoder, Vlp16(), 40, 115).size(), 1u);
  std::vector<RecordedScan> none;
  decoder->Flush(&none);
  EXPECT_TRUE(none.empty());
}

TEST(VelodyneDecoder, RefusesWhatIsNoPacket) {
  const auto decoder = Make();
  std::vector<RecordedScan> scans;
  const std::string good = VelodynePacketOf(Vlp16(), 0, 0);
  std::string flag = good, azimuth = good, product = good;
  flag[300] = 'x';
  azimuth[102] = azimuth[103] = '\xFF';
  product[1205] = '\xA3';
  for (const std::string& bad : {std::string(), good.substr(1), good + "x", flag, azimuth, product,
                                 std::string(1206, '\0')}) {
    const absl::Status status = decoder->Add(bad, 0, &scans);
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  }
  EXPECT_TRUE(scans.empty());
  EXPECT_TRUE(decoder->Add(good, INT64_MIN, &scans).ok());
  EXPECT_TRUE(decoder->Add(good, INT64_MAX, &scans).ok());
  EXPECT_TRUE(IsVelodynePacket(good));
  EXPECT_FALSE(IsVelodynePacket(good.substr(1)));
  EXPECT_THAT(decoder->Assumptions(), Not(Contains("")));
}

TEST(VelodyneDecoder, FieldsOfViewDoNotChangeTheSpeed) {
  // Blocks 0 to 5 at the end of the field of view, 6 to 11 at its beginning, 100 degrees on.
  std::array<testing::VelodyneBlock, 12> blocks;
  for (size_t b = 0; b < 12; ++b) {
    blocks[b].azimuth = static_cast<int>(b) * 40 + (b > 5 ? 10000 : 0);
    blocks[b].ranges.fill(5000);
  }
  const auto decoder = Make();
  std::vector<RecordedScan> scans;
  ASSERT_TRUE(
      decoder->Add(testing::VelodynePacket(blocks, 0, 0x37, 0x22), kVelodyneHour, &scans).ok());
  decoder->Flush(&scans);
  const Points points = PointsOf(scans.at(0));
  const double last = std::atan2(-points.y[5 * 32 + 31], points.x[5 * 32 + 31]) / kDeg;
  EXPECT_NEAR(last, 2.0 + 0.4 * (55.296 + 15 * 2.304) / 110.592, 1e-3);
  // The lasers were dark while the sensor turned by 100 degrees.
  const double dark_s = 100.0 / 0.4 * 110.592e-6;
  EXPECT_NEAR(points.time[6 * 32] - points.time[0], 6 * 110.592e-6 + dark_s, 1e-7);
}

// VLS-128 User Manual: four banks of 32, eight lasers at once each 2.665 us with a pause in the
// middle, 53.3 us from firing to firing, and a packet is stamped 8.7 us behind its start.
std::string Vls128Packet(int azimuth, bool dual) {
  std::array<testing::VelodyneBlock, 12> blocks = {};
  const uint16_t flags[] = {0xEEFF, 0xDDFF, 0xCCFF, 0xBBFF};
  const int returns = dual ? 2 : 1;
  for (int i = 0; i < 12; ++i) {
    const int firing = i / (4 * returns), bank = i / returns % 4;
    blocks[i].flag = firing < 3 / returns ? flags[bank] : 0;
    blocks[i].azimuth = azimuth + 20 * firing;
    for (int laser = 0; laser < 32; ++laser) {
      blocks[i].ranges[laser] = static_cast<uint16_t>(2500 + (dual ? i % 2 * 250 : 0));
    }
  }
  return testing::VelodynePacket(blocks, 1000, dual ? 0x39 : 0x37, 0xA1);
}

TEST(VelodyneDecoder, ReadsTheFourBanksOfAVls128) {
  const auto decoder = Make();
  std::vector<RecordedScan> scans;
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(decoder->Add(Vls128Packet(9000 + 60 * i, false), kVelodyneHour, &scans).ok());
  }
  decoder->Flush(&scans);
  EXPECT_EQ(decoder->sensor(), "vls128");
  const Points points = PointsOf(scans.at(0));
  ASSERT_EQ(points.x.size(), 2u * 3 * 128);
  EXPECT_EQ(std::set<double>(points.ring.begin(), points.ring.end()).size(), 128u);
  const double start_s = points.time[0];
  const double speed = 20 / 53.3e-6 / 100;  // Degrees per second.
  const auto expect = [&](size_t laser, size_t firing, double elevation, double offset) {
    const size_t i = firing * 128 + laser;
    const double delay_s =
        static_cast<double>(firing) * 53.3e-6 + (laser / 8 + (laser >= 64 ? 1 : 0)) * 2.665e-6;
    const double azimuth = (90 + delay_s * speed + offset) * kDeg;
    EXPECT_NEAR(points.time[i] - start_s, delay_s, 2e-7) << laser;
    EXPECT_NEAR(points.x[i], 10 * std::cos(elevation * kDeg) * std::cos(azimuth), 1e-3) << laser;
    EXPECT_NEAR(points.y[i], -10 * std::cos(elevation * kDeg) * std::sin(azimuth), 1e-3) << laser;
    EXPECT_NEAR(points.z[i], 10 * std::sin(elevation * kDeg), 1e-3) << laser;
  };
  for (const size_t firing : {0, 1, 2}) {
    expect(0, firing, -11.742, 6.354);
    expect(36, firing, -25, -0.911);
    expect(59, firing, 15, 0.911);
    expect(127, firing, 0.43, -6.354);
  }
}

TEST(VelodyneDecoder, ReadsBothReturnsOfAVls128) {
  const auto decoder = Make();
  std::vector<RecordedScan> scans;
  ASSERT_TRUE(decoder->Add(Vls128Packet(9000, true), kVelodyneHour, &scans).ok());
  decoder->Flush(&scans);
  const Points points = PointsOf(scans.at(0));
  ASSERT_EQ(points.x.size(), 2u * 128);
  // Bank by bank, of each the first return and then the second, at the same time.
  for (size_t i = 0; i < points.x.size(); ++i) {
    const double range = std::hypot(points.x[i], points.y[i], points.z[i]);
    EXPECT_NEAR(range, i / 32 % 2 == 0 ? 10 : 11, 1e-3) << i;
    EXPECT_EQ(points.time[i], points.time[i - i / 32 % 2 * 32]) << i;
  }
}

}  // namespace
}  // namespace isthmus::readers
