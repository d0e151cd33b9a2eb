#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>

#include "client/readers/packets/maker.h"
#include "client/readers/packets/packet_decoder.h"
#include "core/codec/payload_layout.h"
#include "core/geometry/angles.h"
#include "tests/client/readers/packets/packet_writer.h"

namespace isthmus::readers {
namespace {

using testing::Append;

constexpr int64_t kLivoxStart = 1'700'000'000'000'000'000;

// Millimetres of point i of a packet.
int64_t LivoxX(int i) { return 5000 + 10 * i; }
int64_t LivoxY(int i) { return -3000 + 10 * i; }
int64_t LivoxZ(int i) { return 1000 - 10 * i; }

using PointWriter = std::function<void(std::string& bytes, int firing)>;

void AppendXyz(std::string& bytes, int i, int size, int unit_mm) {
  for (const int64_t value : {LivoxX(i), LivoxY(i), LivoxZ(i)}) {
    Append(bytes, static_cast<uint64_t>(value / unit_mm), size);
  }
}

// Depth, zenith angle and azimuth, 0.01 degrees, of a point on a sphere of 5 m.
void AppendAngles(std::string& bytes, int i) {
  Append(bytes, static_cast<uint64_t>(6000 + 10 * i), 2);
  Append(bytes, static_cast<uint64_t>(30000 + 20 * i), 2);
}

std::string Sdk2Packet(int type, int count, int64_t time_ns, const PointWriter& write) {
  std::string points;
  for (int i = 0; i < count; ++i) write(points, i);
  std::string bytes(1, '\0');
  Append(bytes, 36 + points.size(), 2);
  Append(bytes, static_cast<uint64_t>(count) * 50, 2);  // 5 us from point to point.
  Append(bytes, static_cast<uint64_t>(count), 2);
  bytes.append(3, '\0');
  bytes += static_cast<char>(type);
  bytes.append(17, '\0');
  Append(bytes, static_cast<uint64_t>(time_ns), 8);
  return bytes + points;
}

std::string Sdk1Packet(int type, int count, uint64_t stamp, int stamp_type,
                       const PointWriter& write) {
  std::string bytes("\x05\x01\x01\0\0\0\0\0", 8);
  bytes += static_cast<char>(stamp_type);
  bytes += static_cast<char>(type);
  Append(bytes, stamp, 8);
  for (int i = 0; i < count; ++i) write(bytes, i);
  return bytes;
}

std::vector<RecordedScan> DecodeLivoxPackets(const std::vector<std::string>& packets,
                                             int64_t delay_ns = 0) {
  const auto decoder = MakeLivoxDecoder({});
  std::vector<RecordedScan> scans;
  for (const std::string& packet : packets) {
    const absl::Status status = (*decoder)->Add(packet, kLivoxStart + delay_ns, &scans);
    EXPECT_TRUE(status.ok()) << status;
  }
  (*decoder)->Flush(&scans);
  return scans;
}

std::vector<double> LivoxColumn(const RecordedScan& scan, const char* name) {
  return codec::ReadColumn(scan.payload, *codec::FindField(scan.payload, {name}));
}

void Tail(std::string& bytes, int i) {
  Append(bytes, static_cast<uint64_t>(i), 1);
  Append(bytes, static_cast<uint64_t>(i + 1), 1);
}

// Each firing a point, in millimetres or centimetres.
void ExpectLine(const RecordedScan& scan, size_t count, double interval_s) {
  const auto x = LivoxColumn(scan, "x"), y = LivoxColumn(scan, "y"), z = LivoxColumn(scan, "z"),
             time = LivoxColumn(scan, "time"), intensity = LivoxColumn(scan, "intensity");
  ASSERT_EQ(x.size(), count);
  for (size_t i = 0; i < count; ++i) {
    const int k = static_cast<int>(i);
    EXPECT_NEAR(x[i], static_cast<double>(LivoxX(k)) * 1e-3, 1e-6);
    EXPECT_NEAR(y[i], static_cast<double>(LivoxY(k)) * 1e-3, 1e-6);
    EXPECT_NEAR(z[i], static_cast<double>(LivoxZ(k)) * 1e-3, 1e-6);
    EXPECT_EQ(intensity[i], k);
    EXPECT_NEAR(time[i] - time[0], interval_s * k, 1e-8);
  }
}

// A point at 5 m by its angles.
void ExpectOnSphere(const RecordedScan& scan, size_t point, int firing, double range) {
  const double zenith = (60 + 0.1 * firing) * kRadPerDeg;
  const double azimuth = (300 + 0.2 * firing) * kRadPerDeg;
  EXPECT_NEAR(LivoxColumn(scan, "x")[point], range * std::sin(zenith) * std::cos(azimuth), 1e-5);
  EXPECT_NEAR(LivoxColumn(scan, "y")[point], range * std::sin(zenith) * std::sin(azimuth), 1e-5);
  EXPECT_NEAR(LivoxColumn(scan, "z")[point], range * std::cos(zenith), 1e-5);
}

TEST(LivoxDecoder, ReadsTheLayoutsOfSdk2) {
  const std::string millimetres = Sdk2Packet(1, 96, kLivoxStart, [](std::string& bytes, int i) {
    AppendXyz(bytes, i, 4, 1);
    Tail(bytes, i);
  });
  EXPECT_EQ(MakerOf(millimetres, millimetres.size()), Maker::kLivox);
  const std::vector<RecordedScan> scans = DecodeLivoxPackets({millimetres});
  ExpectLine(scans.at(0), 96, 5e-6);
  EXPECT_EQ(scans[0].end_stamp_ns, kLivoxStart + 95 * 5000);
  EXPECT_EQ(LivoxColumn(scans[0], "tag")[7], 8);
  ExpectLine(DecodeLivoxPackets({Sdk2Packet(2, 96, kLivoxStart,
                                            [](std::string& bytes, int i) {
                                              AppendXyz(bytes, i, 2, 10);
                                              Tail(bytes, i);
                                            })})
                 .at(0),
             96, 5e-6);
  const RecordedScan sphere =
      DecodeLivoxPackets({Sdk2Packet(3, 80, kLivoxStart, [](std::string& bytes, int i) {
        Append(bytes, 5000, 4);
        AppendAngles(bytes, i);
        Tail(bytes, i);
      })}).at(0);
  for (const int i : {0, 79}) ExpectOnSphere(sphere, static_cast<size_t>(i), i, 5);
}

TEST(LivoxDecoder, ReadsTheLayoutsOfTheFirstSdk) {
  const auto plain = [](std::string& bytes, int i) {
    AppendXyz(bytes, i, 4, 1);
    Append(bytes, static_cast<uint64_t>(i), 1);
  };
  const auto at = [&](int64_t time_ns) {
    return Sdk1Packet(0, 100, static_cast<uint64_t>(time_ns), 0, plain);
  };
  EXPECT_EQ(MakerOf(at(0), at(0).size()), Maker::kLivox);
  // The second packet shows that the sensor fires each 10 us, as a Mid-40.
  const std::vector<RecordedScan> scans =
      DecodeLivoxPackets({at(kLivoxStart), at(kLivoxStart + 1'000'000)});
  const auto time = LivoxColumn(scans.at(0), "time");
  ASSERT_EQ(time.size(), 200u);
  EXPECT_NEAR(time[199] - time[100], 99 * 10e-6, 1e-8);
  EXPECT_NEAR(time[100] - time[0], 1e-3, 1e-8);
  EXPECT_EQ(scans[0].end_stamp_ns, kLivoxStart + 1'990'000);
}

TEST(LivoxDecoder, ReadsBothReturnsOfAnAvia) {
  const std::string cartesian =
      Sdk1Packet(4, 48, static_cast<uint64_t>(kLivoxStart), 1, [](std::string& bytes, int i) {
        for (const int echo : {0, 1}) {
          AppendXyz(bytes, 2 * i + echo, 4, 1);
          Tail(bytes, i);
        }
      });
  const RecordedScan scan = DecodeLivoxPackets({cartesian}).at(0);
  const auto x = LivoxColumn(scan, "x"), time = LivoxColumn(scan, "time");
  ASSERT_EQ(x.size(), 96u);
  EXPECT_NEAR(x[95], static_cast<double>(LivoxX(95)) * 1e-3, 1e-6);
  EXPECT_EQ(time[94], time[95]);
  EXPECT_NEAR(time[95] - time[0], 47 * 4.167e-6, 1e-8);
  const RecordedScan sphere =
      DecodeLivoxPackets({Sdk1Packet(5, 48, static_cast<uint64_t>(kLivoxStart), 1,
                                     [](std::string& bytes, int i) {
                                       AppendAngles(bytes, i);
                                       for (const uint64_t depth : {5000, 7000}) {
                                         Append(bytes, depth, 4);
                                         Tail(bytes, i);
                                       }
                                     })})
          .at(0);
  ExpectOnSphere(sphere, 40, 20, 5);
  ExpectOnSphere(sphere, 41, 20, 7);
  EXPECT_EQ(LivoxColumn(sphere, "tag")[41], 21);
}

TEST(LivoxDecoder, TakesADateOfGpsForTime) {
  // 2023-11-14 22 h, and 13 min 20 s: kLivoxStart.
  std::string date("\x17\x0B\x0E\x16", 4);
  Append(date, 800'000'000, 4);
  uint64_t stamp = 0;
  std::memcpy(&stamp, date.data(), 8);
  const auto points = [](std::string& bytes, int i) {
    AppendXyz(bytes, i, 4, 1);
    Tail(bytes, i);
  };
  const RecordedScan scan = DecodeLivoxPackets({Sdk1Packet(2, 96, stamp, 3, points)}, 7000).at(0);
  EXPECT_EQ(scan.end_stamp_ns, kLivoxStart + 95 * 4167);
}

TEST(LivoxDecoder, CutsScansEach100MsAndLeavesOutWhatDidNotReturn) {
  std::vector<std::string> packets;
  for (int i = 0; i < 25; ++i) {
    packets.push_back(
        Sdk2Packet(1, 10, kLivoxStart + i * 10'000'000, [](std::string& bytes, int k) {
          if (k < 4) {
            AppendXyz(bytes, k, 4, 1);
          } else {
            bytes.append(12, '\0');
          }
          Tail(bytes, k);
        }));
  }
  const std::vector<RecordedScan> scans = DecodeLivoxPackets(packets);
  ASSERT_EQ(scans.size(), 3u);
  EXPECT_EQ(scans[0].payload.width, 40u);
  EXPECT_EQ(scans[2].payload.width, 20u);
}

TEST(LivoxDecoder, SkipsTheImuAndRefusesOthers) {
  const auto decoder = MakeLivoxDecoder({.sensor = "mid360"});
  std::vector<RecordedScan> scans;
  const std::string imu = Sdk1Packet(6, 1, 0, 0, [](std::string& b, int) { b.append(24, '\0'); });
  EXPECT_TRUE((*decoder)->Add(imu, 0, &scans).ok());
  EXPECT_FALSE(MakerOf(imu, imu.size()).has_value());
  std::string good = Sdk2Packet(1, 3, 0, [](std::string& bytes, int i) {
    AppendXyz(bytes, i, 4, 1);
    Tail(bytes, i);
  });
  std::string type = good;
  type[10] = '\x07';
  for (const std::string& bad : {std::string(), good.substr(1), good + "x", type}) {
    EXPECT_TRUE(absl::IsInvalidArgument((*decoder)->Add(bad, 0, &scans)));
  }
  EXPECT_TRUE((*decoder)->Add(good, INT64_MIN, &scans).ok());
  EXPECT_TRUE((*decoder)->Add(good, INT64_MAX, &scans).ok());
  EXPECT_EQ((*decoder)->sensor(), "livox");
}

}  // namespace
}  // namespace isthmus::readers
