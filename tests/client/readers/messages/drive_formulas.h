// The drive that the recordings in tests/client/readers/data hold, by formula.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/readers/messages/message_recording.h"
#include "core/codec/payload_layout.h"

namespace isthmus::readers {

inline constexpr int64_t kDriveStartNs = 1'700'000'000'000'000'000;

inline std::string DataFile(const std::string& name) {
  return std::string(ISTHMUS_READERS_DATA) + "/" + name;
}

inline std::vector<double> Column(const PointPayload& payload, const char* name) {
  const PointField* field = codec::FindField(payload, {name});
  return field == nullptr ? std::vector<double>() : codec::ReadColumn(payload, *field);
}

// The values of `count` points, which `value` makes of their numbers.
template <typename Value>
std::vector<double> EachPoint(int count, const Value& value) {
  std::vector<double> values;
  values.reserve(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) values.push_back(static_cast<double>(value(i)));
  return values;
}

// Scan k of /a/points: two padded rows of three points, times in seconds from the start.
inline void ExpectScanA(const RecordedScan& scan, int k) {
  // Its times are float32: 0.1 is not.
  EXPECT_NEAR(scan.end_stamp_ns - kDriveStartNs, (k + 1) * 100'000'000, 2) << k;
  EXPECT_EQ(scan.name, "scan " + std::to_string(k) + " of /a/points");
  EXPECT_EQ(scan.payload.width, 3u);
  EXPECT_EQ(scan.payload.height, 2u);
  EXPECT_EQ(scan.payload.stride, 32u);
  EXPECT_EQ(scan.payload.data.size(), 6u * 32);
  EXPECT_EQ(Column(scan.payload, "x"), EachPoint(6, [&](int i) { return 10 * (k + 1) + i; }));
  EXPECT_EQ(Column(scan.payload, "y"), EachPoint(6, [](int i) { return -i; }));
  EXPECT_EQ(Column(scan.payload, "z"), EachPoint(6, [&](int i) { return 0.5 * i + k; }));
  EXPECT_EQ(Column(scan.payload, "intensity"), EachPoint(6, [](int i) { return 2 * i; }));
  EXPECT_EQ(Column(scan.payload, "ring"), EachPoint(6, [](int i) { return i / 3; }));
  EXPECT_EQ(Column(scan.payload, "time"),
            EachPoint(6, [](int i) { return static_cast<float>(0.02 * i); }));
}

// Scan k of /b/points: big endian doubles, times in nanoseconds.
inline void ExpectScanB(const RecordedScan& scan, int k) {
  EXPECT_EQ(scan.end_stamp_ns, kDriveStartNs + 20'000'000 + k * 100'000'000 + 90'000'000) << k;
  EXPECT_EQ(Column(scan.payload, "x"), EachPoint(4, [&](int i) { return 100 * k + i; }));
  EXPECT_EQ(Column(scan.payload, "y"), EachPoint(4, [](int i) { return i / 8.0; }));
  EXPECT_EQ(Column(scan.payload, "z"), EachPoint(4, [&](int) { return -k; }));
  EXPECT_EQ(Column(scan.payload, "t"), EachPoint(4, [](int i) { return 30'000'000.0 * i; }));
}

// Scan k of /livox/lidar.
inline void ExpectLivox(const RecordedScan& scan, int k) {
  EXPECT_EQ(scan.end_stamp_ns, kDriveStartNs + (k + 1) * 100'000'000) << k;
  EXPECT_EQ(Column(scan.payload, "x"), EachPoint(3, [&](int i) { return i + k; }));
  EXPECT_EQ(Column(scan.payload, "y"), EachPoint(3, [](int i) { return 2 * i; }));
  EXPECT_EQ(Column(scan.payload, "z"), EachPoint(3, [](int i) { return 3 * i; }));
  EXPECT_EQ(Column(scan.payload, "intensity"), EachPoint(3, [](int i) { return 10 * i; }));
  EXPECT_EQ(Column(scan.payload, "time"), EachPoint(3, [](int i) { return 50'000'000.0 * i; }));
  EXPECT_EQ(Column(scan.payload, "ring"), EachPoint(3, [](int i) { return i; }));
  EXPECT_EQ(Column(scan.payload, "tag"), EachPoint(3, [](int i) { return i + 1; }));
}

// Byte j of packet p of the only message on /velodyne_packets.
inline char VelodyneByte(int p, int j) { return static_cast<char>(7 * j + p); }
// Byte j of packet k on /os/lidar_packets.
inline char OusterByte(int k, int j) { return static_cast<char>(3 * j + k); }

// A decoder that makes each packet a scan: its bytes are the payload's data, its arrival the END.
class PacketEcho : public PacketDecoder {
 public:
  explicit PacketEcho(std::string sensor) : sensor_(std::move(sensor)) {}
  absl::Status Add(absl::string_view packet, int64_t arrival_ns,
                   std::vector<RecordedScan>* scans) override {
    if (packet.size() < 60) return absl::InvalidArgumentError("too small");
    RecordedScan scan;
    scan.end_stamp_ns = arrival_ns;
    scan.payload.data = std::string(packet);
    scans->push_back(std::move(scan));
    return absl::OkStatus();
  }
  void Flush(std::vector<RecordedScan>*) override {}
  std::string sensor() const override { return sensor_; }
  std::vector<std::string> Assumptions() const override { return {"packets are echoed"}; }

 private:
  const std::string sensor_;
};

// Ouster's echo calls itself what its metadata are.
inline PacketDecoderFactories EchoFactories() {
  PacketDecoderFactories factories;
  factories.packets = [](absl::string_view, const PacketOptions& options) {
    return std::make_unique<PacketEcho>(options.by_flush ? "turns" : "packets");
  };
  factories.ouster = [](const std::string& metadata) {
    return std::make_unique<PacketEcho>(metadata);
  };
  return factories;
}

// All that a topic of a recording gives.
struct ReadAll {
  std::vector<RecordedScan> scans;
  std::vector<std::string> errors;
};
inline ReadAll ReadTopic(const Recording& recording, const std::string& topic,
                         const ReadOptions& options = {}) {
  ReadAll all;
  for (size_t i = 0; i < recording.scan_topics().size(); ++i) {
    if (recording.scan_topics()[i].name != topic) continue;
    auto reader = recording.OpenScans(i, options);
    if (!reader.ok()) all.errors.emplace_back(reader.status().message());
    while (reader.ok()) {
      auto scan = (*reader)->Next();
      if (!scan.ok()) {
        all.errors.emplace_back(scan.status().message());
        if (all.errors.size() > 1000) return all;  // Every recording ends.
        continue;
      }
      if (!scan->has_value()) break;
      all.scans.push_back(**std::move(scan));
    }
  }
  return all;
}

}  // namespace isthmus::readers
