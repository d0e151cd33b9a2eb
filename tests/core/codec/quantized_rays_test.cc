// Version 2 of quantised payloads: scans as distances along the rays of a model.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "core/byte_stream.h"
#include "core/codec/payload_builder.h"
#include "core/codec/payload_layout.h"
#include "core/codec/quantized.h"
#include "core/codec/zstd_frame.h"
#include "core/io/crc32c.h"
#include "tests/core/codec/payloads.h"

namespace isthmus::codec {
namespace {

using ::testing::HasSubstr;

constexpr double kStep = 0.002;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Expects that coordinates come back as near as promised and other fields bit by bit, that both
// versions agree bit by bit, and that the newer one is not larger. Returns the version that was
// chosen.
int ExpectKept(const PointPayload& raw, double step = kStep) {
  const auto now = Quantize(raw, step), before = Quantize(raw, step, 1);
  EXPECT_TRUE(now.ok() && before.ok()) << now.status() << before.status();
  if (!now.ok() || !before.ok()) return 0;
  EXPECT_EQ(QuantizedVersionOf(*before), 1);
  EXPECT_LE(now->data.size(), before->data.size() + 8);
  const auto back = Dequantize(*now), back_before = Dequantize(*before);
  EXPECT_TRUE(back.ok() && back_before.ok()) << back.status() << back_before.status();
  if (!back.ok() || !back_before.ok()) return 0;
  EXPECT_EQ(back->data, back_before->data);
  const uint64_t n = PointCount(raw);
  for (const PointField& field : raw.fields) {
    const auto a = ReadColumn(raw, field), b = ReadColumn(*back, field);
    const bool coordinate =
        field.name.size() == 1 && std::string("xXyz").find(field.name) != std::string::npos;
    const uint32_t width = SizeOf(field.type) * field.count;
    int wrong = 0;
    for (uint64_t i = 0; i < n; ++i) {
      const size_t at = i * raw.stride + field.offset;
      if (!coordinate) {
        wrong += raw.data.compare(at, width, back->data, at, width) != 0;
      } else if (!std::isfinite(a[i])) {
        wrong += !std::isnan(b[i]);
      } else {
        // Half a step, and what float32 cannot hold.
        wrong += !(std::abs(a[i] - b[i]) <= step / 2 + std::abs(a[i]) * 1.2e-7);
      }
    }
    EXPECT_EQ(wrong, 0) << field.name;
  }
  return QuantizedVersionOf(*now);
}

int ExpectKept(const std::vector<ScanPoint>& points, bool rings = true, bool times = true) {
  return ExpectKept(MakePayload(points, rings, times));
}

// The room, changed point by point.
std::vector<ScanPoint> Changed(const std::function<void(ScanPoint&)>& change, int columns = 900) {
  std::vector<ScanPoint> points = RoomScan(columns);
  for (ScanPoint& p : points) change(p);
  return points;
}

TEST(QuantizedRays, ASpinningLidarTakesLessThanHalf) {
  const PointPayload raw = MakePayload(RoomScan(1800), true, true);
  const auto now = Quantize(raw, kStep), before = Quantize(raw, kStep, 1);
  ASSERT_TRUE(now.ok() && before.ok());
  EXPECT_EQ(QuantizedVersionOf(*now), 2);
  EXPECT_LT(2 * now->data.size(), before->data.size());
  EXPECT_EQ(ExpectKept(raw), 2);
}

TEST(QuantizedRays, FollowsSensorsThatAreNotIdeal) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal(0, 1);
  // Each ring looks elsewhere, as of lasers that sit beside each other.
  EXPECT_EQ(ExpectKept(Changed([](ScanPoint& p) {
              const float a = 0.02f * static_cast<float>(p.ring % 4);
              const float x = p.x;
              p.x = x * std::cos(a) - p.y * std::sin(a);
              p.y = x * std::sin(a) + p.y * std::cos(a);
            })),
            2);
  // The axis is beside the origin, and above it.
  EXPECT_EQ(ExpectKept(Changed([](ScanPoint& p) {
              const float rho = std::hypot(p.x, p.y);
              const float x = p.x;
              p.x -= 0.03f * p.y / rho;
              p.y += 0.03f * x / rho;
              p.z += 0.04f;
            })),
            2);
  // Azimuths to a hundredth of a degree.
  EXPECT_EQ(ExpectKept(Changed([&](ScanPoint& p) {
              const float e = 5e-5f * normal(random), x = p.x;
              p.x -= e * p.y;
              p.y += e * x;
            })),
            2);
  // Motion is compensated for: 2 m/s and half a turn in 10 s.
  EXPECT_EQ(ExpectKept(Changed([](ScanPoint& p) {
              const float a = 0.3f * p.time, x = p.x;
              p.x = x * std::cos(a) - p.y * std::sin(a) + 2 * p.time;
              p.y = x * std::sin(a) + p.y * std::cos(a);
            })),
            2);
}

TEST(QuantizedRays, KeepsWhatFollowsNoRays) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-50, 50);
  ExpectKept(RoomScan(), false, true);
  ExpectKept(RoomScan(), true, false);
  ExpectKept(RoomScan(), false, false);
  ExpectKept(Changed([&](ScanPoint& p) {  // Directions that have nothing to do with ring or time.
    p.x = uniform(random);
    p.y = uniform(random);
    p.z = uniform(random);
  }));
  ExpectKept(Changed([](ScanPoint& p) {  // Mounted upright on its side.
    std::swap(p.x, p.z);
  }));
  ExpectKept(Changed([](ScanPoint& p) { p.time = 7; }));
  ExpectKept(Changed([](ScanPoint& p) { p.time = kNan; }));
  ExpectKept(Changed([](ScanPoint& p) { p.ring = 60000; }));
  ExpectKept(Changed([](ScanPoint& p) { p.x = p.y = p.z = kNan; }));
  ExpectKept(Changed([](ScanPoint& p) { p.x = p.y = p.z = 0; }));
  std::vector<ScanPoint> points = RoomScan(900);
  std::shuffle(points.begin(), points.end(), random);
  ExpectKept(points);
  std::vector<ScanPoint> twice;  // Dual returns.
  for (const ScanPoint& p : RoomScan(900)) {
    twice.push_back(p);
    twice.push_back(p);
    twice.back().x *= 1.3f;
    twice.back().y *= 1.3f;
    twice.back().z *= 1.3f;
  }
  ExpectKept(twice);
}

TEST(QuantizedRays, KeepsAnyNumberOfPoints) {
  const std::vector<ScanPoint> all = RoomScan(40);
  for (const size_t n : {1, 2, 3, 15, 16, 17, 255, 256, 257, 511, 512, 513}) {
    ExpectKept(std::vector<ScanPoint>(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(n)));
  }
}

TEST(QuantizedRays, KeepsPointsThatAreNoReturnsInTheirPlace) {
  std::mt19937 random(9);
  const auto spoil = [&](float value) {
    return Changed([&random, value](ScanPoint& p) {
      if (random() % 5 == 0) p.x = p.y = p.z = value;
    });
  };
  EXPECT_EQ(ExpectKept(spoil(kNan)), 2);
  EXPECT_EQ(ExpectKept(spoil(0)), 2);
  EXPECT_EQ(ExpectKept(spoil(std::numeric_limits<float>::infinity())), 2);
  // Only one of three is missing: rays cannot tell, differences can.
  EXPECT_EQ(ExpectKept(Changed([&](ScanPoint& p) {
              if (random() % 5 == 0) p.y = kNan;
            })),
            1);
}

TEST(QuantizedRays, KeepsPointsFarAndNear) {
  std::mt19937 random(9);
  for (const float scale : {1e-3f, 0.1f, 100.0f, 1e4f, 5e4f}) {
    ExpectKept(Changed([&](ScanPoint& p) {
      const float s = random() % 7 == 0 ? scale : 1;
      p.x *= s;
      p.y *= s;
      p.z *= s;
    }));
  }
  ExpectKept(MakePayload(Changed([](ScanPoint& p) { p.x += 1e6f; }), true, true), 0.005);
  EXPECT_THAT(
      std::string(
          Quantize(MakePayload(Changed([](ScanPoint& p) { p.x += 2e6f; }), true, true), kStep)
              .status()
              .message()),
      HasSubstr("beyond"));
}

// Fields of other types and orders, gaps in the records, columns that share bytes.
TEST(QuantizedRays, KeepsEveryLayout) {
  using enum ScalarType;
  const std::vector<ScanPoint> room = RoomScan(400);
  const auto n = static_cast<uint32_t>(room.size());
  PointPayload payload =
      PayloadOf(n)
          .Add<uint32_t>("t", kUint32, [&](uint32_t i) { return 1e9 * (room[i].time + 0.1); })
          .Add<double>("z", kFloat64, [&](uint32_t i) { return room[i].z; })
          .Add<uint8_t>("channel", kUint8, [&](uint32_t i) { return room[i].ring; })
          .Add<double>("X", kFloat64, [&](uint32_t i) { return room[i].x; })
          .Add<uint16_t>("ambient", kUint16, [](uint32_t i) { return i * 40503; })
          .Add<double>("y", kFloat64, [&](uint32_t i) { return room[i].y; })
          .Build();
  EXPECT_EQ(ExpectKept(payload), 2);
  payload.fields[3].name = "x";
  payload.height = 16;
  payload.width /= 16;
  EXPECT_EQ(ExpectKept(payload), 2);
  payload.fields.push_back({"rgb", payload.fields[1].offset + 2, kUint8, 3});  // Shares z's bytes.
  const auto quantized = Quantize(payload, kStep);
  ASSERT_TRUE(quantized.ok());
  EXPECT_EQ(QuantizedVersionOf(*quantized), 1);
}

TEST(QuantizedRays, KeepsScansWhateverTheyAre) {
  for (uint32_t seed = 1; seed <= 60; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal(0, 1);
    const float angle = 0.002f * static_cast<float>(random() % 5), jump = (random() % 3) * 3.0f;
    const float far = random() % 2 == 0 ? 1 : 20;
    ExpectKept(Changed(
        [&](ScanPoint& p) {
          const float s = (random() % 10 == 0 ? 1 + jump : 1) * far, e = angle * normal(random);
          const float x = p.x;
          p.x = s * (x - e * p.y);
          p.y = s * (p.y + e * x);
          p.z *= s;
          p.ring = static_cast<uint16_t>(p.ring + (seed % 4) * 50);
          p.time *= seed % 3 == 0 ? -1.0f : 1.0f;
        },
        60 + static_cast<int>(seed) * 5));
  }
}

// Damage in any byte and truncation at any place is noticed.
TEST(QuantizedRays, RefusesDamage) {
  const auto good = Quantize(MakePayload(RoomScan(60), true, true), 0.005);
  ASSERT_TRUE(good.ok());
  ASSERT_EQ(QuantizedVersionOf(*good), 2);
  for (size_t i = 0; i < good->data.size(); ++i) {
    PointPayload bad = *good;
    bad.data[i] = static_cast<char>(bad.data[i] ^ 0x10);
    ASSERT_EQ(Dequantize(bad).status().code(), absl::StatusCode::kInvalidArgument) << i;
    bad = *good;
    bad.data.resize(i);
    ASSERT_EQ(Dequantize(bad).status().code(), absl::StatusCode::kInvalidArgument) << i;
  }
}

// Three points x y z ring (uint8) time (uint8), put together by hand.
struct ByHand {
  std::string transforms = std::string("\4\4\4\0\0", 5);
  std::string rings = std::string("\0\0\0", 3), times = std::string("\0\0\0", 3);
  uint16_t ring_column = 3, time_column = 4, models = 1;
  double turns_per_unit = 0;
  uint32_t escape_bytes = 2;
  // 1000 is 1024 + 976 when folded, 11 bits: symbol 208 + 3, and 976 in 10 bits. Then 3 more, and a
  // point that is none.
  std::string distances = std::string("\323\6\377", 3), across = std::string("\x0a\0\0", 3);
  std::string escapes = std::string("\xd0\3", 2);

  PointPayload Build() const {
    std::string body = transforms, frame;
    EXPECT_TRUE(AppendZstdFrame(rings + times, frame).ok());
    AppendBytes(static_cast<uint32_t>(frame.size()), body);
    body += frame;
    AppendBytes(ring_column, body);
    AppendBytes(time_column, body);
    AppendBytes(models, body);
    body += "\240\60\20\20";  // Gains 160, 48, 16, 16.
    AppendBytes(turns_per_unit, body);
    for (int i = 0; i < models; ++i) body.append(16, '\0');
    AppendBytes(escape_bytes, body);
    EXPECT_TRUE(AppendZstdFrame(distances + across + escapes, body).ok());
    PointPayload payload;
    payload.encoding = PayloadEncoding::kQuantized;
    payload.width = 3;
    payload.stride = 14;
    payload.resolution_m = 0.001;
    payload.fields = {{"x", 0},
                      {"y", 4},
                      {"z", 8},
                      {"ring", 12, ScalarType::kUint8},
                      {"time", 13, ScalarType::kUint8}};
    payload.data = std::string("IQ\2\0", 4);
    AppendBytes(io::Crc32c(body.data(), body.size()), payload.data);
    payload.data += body;
    return payload;
  }
};

// Data of version 2 stays readable: the worked example of docs/storage-format.md.
TEST(QuantizedRays, ReadsTheDocumentedExample) {
  const auto raw = Dequantize(ByHand().Build());
  ASSERT_TRUE(raw.ok()) << raw.status();
  const auto x = ReadColumn(*raw, raw->fields[0]), y = ReadColumn(*raw, raw->fields[1]);
  const auto z = ReadColumn(*raw, raw->fields[2]);
  EXPECT_FLOAT_EQ(static_cast<float>(x[0]), 1.0f);
  EXPECT_EQ(y[0], 0);
  EXPECT_FLOAT_EQ(static_cast<float>(z[0]), 0.005f);
  EXPECT_FLOAT_EQ(static_cast<float>(x[1]), 1.003f);
  EXPECT_EQ(y[1], 0);
  EXPECT_EQ(z[1], 0);  // The ring's slope has become 16 / 256 * 5 / 1000: 0.3 steps.
  EXPECT_TRUE(std::isnan(x[2]) && std::isnan(y[2]) && std::isnan(z[2]));
}

TEST(QuantizedRays, RefusesLies) {
  const auto message = [](const std::function<void(ByHand&)>& change) {
    ByHand lie;
    change(lie);
    const auto status = Dequantize(lie.Build()).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  EXPECT_THAT(message([](ByHand& l) { l.rings[1] = 1; }), HasSubstr("no model"));
  EXPECT_THAT(message([](ByHand& l) { l.models = 0; }), HasSubstr("no model"));
  EXPECT_THAT(message([](ByHand& l) { l.models = 300; }), HasSubstr("cut off"));
  EXPECT_THAT(message([](ByHand& l) { l.ring_column = 0; }), HasSubstr("not of these fields"));
  EXPECT_THAT(message([](ByHand& l) { l.ring_column = 60000; }), HasSubstr("not of these fields"));
  EXPECT_THAT(message([](ByHand& l) { l.time_column = 5; }), HasSubstr("not of these fields"));
  EXPECT_THAT(message([](ByHand& l) { l.time_column = 2; }), HasSubstr("not of these fields"));
  EXPECT_THAT(message([](ByHand& l) { l.escape_bytes = 1; }), HasSubstr("another size"));
  EXPECT_THAT(message([](ByHand& l) { l.escape_bytes = 4'000'000'000; }), HasSubstr("size"));
  EXPECT_THAT(message([](ByHand& l) { l.distances[0] = '\xfd'; }), HasSubstr("nothing"));
  EXPECT_THAT(message([](ByHand& l) { l.distances[0] = 1; }), HasSubstr("do not fit"));
  EXPECT_THAT(message([](ByHand& l) { l.across[1] = '\xff'; }), HasSubstr("do not fit"));
  EXPECT_THAT(message([](ByHand& l) { l.transforms[0] = 0; }), HasSubstr("fields do not fit"));
  EXPECT_THAT(message([](ByHand& l) { l.transforms[3] = 4; }), HasSubstr("fields do not fit"));
  EXPECT_THAT(message([](ByHand& l) { l.rings += "x"; }), HasSubstr("another size"));
  // Numbers that are none lead to points that are wrong, nothing worse.
  ByHand wild;
  wild.turns_per_unit = std::numeric_limits<double>::quiet_NaN();
  wild.times[1] = 7;
  EXPECT_TRUE(Dequantize(wild.Build()).ok());
}

TEST(QuantizedRays, NamesVersionsThatItDoesNotRead) {
  auto later = Quantize(MakePayload(RoomScan(), true, true), kStep);
  ASSERT_TRUE(later.ok());
  later->data[2] = 3;
  EXPECT_THAT(std::string(Dequantize(*later).status().message()),
              HasSubstr("version 3; this program reads versions 1 to 2"));
}

}  // namespace
}  // namespace isthmus::codec
