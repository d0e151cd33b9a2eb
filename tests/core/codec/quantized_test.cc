#include "core/codec/quantized.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "core/codec/payload_builder.h"
#include "core/codec/payload_layout.h"
#include "tests/core/codec/payloads.h"

namespace isthmus::codec {
namespace {

using ::testing::HasSubstr;
using enum ScalarType;

// Every scalar type, two counts above one, and gaps in the record.
PointPayload EveryType() {
  PointPayload payload =
      PayloadOf(500)
          .Add<double>("z", kFloat64, [](uint32_t i) { return -0.01 * i; })
          .Add<int8_t>("a", kInt8, [](uint32_t i) { return i; })
          .Add<uint16_t>("ring", kUint16, [](uint32_t i) { return i % 16; })
          .Add<float>("x", kFloat32, [](uint32_t i) { return 0.1 * i; })
          .Add<int32_t>("b", kInt32, [](uint32_t i) { return -1000000 * int(i); })
          .Add<float>("y", kFloat32, [](uint32_t i) { return 50 - 0.3 * i; })
          .Add<double>("t", kFloat64, [](uint32_t i) { return 1.7e9 + 1e-5 * i; })
          .Add<uint32_t>("c", kUint32, [](uint32_t i) { return i * 2654435761u; })
          .Add<float>("n", kFloat32,
                      [](uint32_t) { return std::numeric_limits<float>::quiet_NaN(); })
          .Build();
  payload.fields.push_back({"pair", 8, kUint8, 1});                           // Overlaps `a`.
  payload.fields.push_back({"triple", payload.fields[7].offset, kUint8, 3});  // Overlaps `c`.
  return payload;
}

TEST(Quantized, KeepsCoordinatesWithinHalfAStepAndTheRestExactly) {
  const PointPayload raw = EveryType();
  for (const double resolution : {0.001, 0.005, 0.1}) {
    const auto quantized = Quantize(raw, resolution);
    ASSERT_TRUE(quantized.ok()) << quantized.status();
    const auto back = Dequantize(*quantized);
    ASSERT_TRUE(back.ok()) << back.status();
    EXPECT_EQ(back->stride, raw.stride);
    ASSERT_EQ(back->data.size(), raw.data.size());
    for (const PointField& field : raw.fields) {
      const bool coordinate = field.name == "x" || field.name == "y" || field.name == "z";
      const uint32_t width = SizeOf(field.type) * field.count;
      const auto before = ReadColumn(raw, field), after = ReadColumn(*back, field);
      for (size_t i = 0; i < 500; ++i) {
        if (coordinate) {
          EXPECT_NEAR(after[i], before[i], resolution / 2 + 1e-5);
        } else {
          const size_t at = i * raw.stride + field.offset;
          EXPECT_EQ(back->data.substr(at, width), raw.data.substr(at, width)) << field.name;
        }
      }
    }
  }
}

// Data of version 1 stays readable: the worked example of docs/storage-format.md.
TEST(Quantized, ReadsTheDocumentedExample) {
  constexpr unsigned char kData[] = {
      0x49, 0x51, 0x01, 0x00, 0xd7, 0xf1, 0x6d, 0x78, 0x02, 0x02, 0x02, 0x00, 0x28, 0xb5, 0x2f,
      0xfd, 0x20, 0x20, 0xbd, 0x00, 0x00, 0x80, 0xd5, 0x09, 0x07, 0x00, 0xe8, 0x01, 0x03, 0x00,
      0x91, 0x02, 0x01, 0x00, 0x20, 0x20, 0x41, 0x41, 0x03, 0x50, 0x04, 0x00, 0x14, 0x41};
  PointPayload quantized = MakePayload(Cloud(2));
  quantized.encoding = PayloadEncoding::kQuantized;
  quantized.resolution_m = 0.001;
  quantized.data.assign(std::begin(kData), std::end(kData));
  const auto raw = Dequantize(quantized);
  ASSERT_TRUE(raw.ok()) << raw.status();
  const auto expected = MakePayload(Cloud{{1.002f, -0.5f, 0.2f, 10}, {1.006f, -0.5f, 0.199f, 10}});
  for (const PointField& field : raw->fields) {
    const auto values = ReadColumn(*raw, field);
    EXPECT_EQ(values, ReadColumn(expected, field)) << field.name;
  }
}

TEST(Quantized, KeepsNoReturnsInTheirPlace) {
  std::vector<ScanPoint> points = RoomScan();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  points[0].x = points[0].y = points[0].z = nan;
  points[100].y = std::numeric_limits<float>::infinity();
  const auto quantized = Quantize(MakePayload(points, true, true), 0.005);
  ASSERT_TRUE(quantized.ok()) << quantized.status();
  const auto back = Dequantize(*quantized);
  ASSERT_TRUE(back.ok()) << back.status();
  const auto y = ReadColumn(*back, *FindField(*back, {"y"}));
  EXPECT_TRUE(std::isnan(y[0]));
  EXPECT_NEAR(y[1], points[1].y, 0.0026);
  EXPECT_TRUE(std::isnan(y[100]));
  EXPECT_NEAR(y[101], points[101].y, 0.0026);
}

TEST(Quantized, PacksAScanToLessThanAThird) {
  const PointPayload raw = MakePayload(RoomScan(1800), true, true);
  const auto quantized = Quantize(raw, 0.005);
  ASSERT_TRUE(quantized.ok()) << quantized.status();
  EXPECT_LT(quantized->data.size() * 3, raw.data.size());
}

TEST(Quantized, IsStableOnceRounded) {
  const auto once = Quantize(MakePayload(RoomScan(), true, true), 0.005);
  ASSERT_TRUE(once.ok());
  const auto back = Dequantize(*once);
  ASSERT_TRUE(back.ok());
  const auto twice = Quantize(*back, 0.005);
  ASSERT_TRUE(twice.ok());
  EXPECT_EQ(twice->data, once->data);
}

TEST(Quantized, RefusesWhatItCannotKeep) {
  const PointPayload good = MakePayload(RoomScan(), true, true);
  for (const double resolution : {0.0, -0.001, 1e-6, 0.2, std::nan("")}) {
    EXPECT_THAT(std::string(Quantize(good, resolution).status().message()),
                HasSubstr("resolution"));
  }
  std::vector<ScanPoint> far = RoomScan();
  far[5].z = 1e6f;
  const auto status = Quantize(MakePayload(far, true, true), 0.001).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("beyond"));
  PointPayload nameless = good;
  nameless.fields[1].name = "";
  EXPECT_EQ(Quantize(nameless, 0.001).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(Quantize(*Quantize(good, 0.001), 0.001).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(Dequantize(good).status().code(), absl::StatusCode::kInvalidArgument);
}

// Damage in any byte and truncation at any place is noticed.
TEST(Quantized, RefusesDamage) {
  const auto good = Quantize(MakePayload(RoomScan(40), true, true), 0.005);
  ASSERT_TRUE(good.ok());
  for (size_t i = 0; i < good->data.size(); ++i) {
    PointPayload bad = *good;
    bad.data[i] = static_cast<char>(bad.data[i] ^ 0x10);
    ASSERT_EQ(Dequantize(bad).status().code(), absl::StatusCode::kInvalidArgument) << i;
    bad = *good;
    bad.data.resize(i);
    ASSERT_EQ(Dequantize(bad).status().code(), absl::StatusCode::kInvalidArgument) << i;
  }
}

TEST(Quantized, RefusesLyingHeaders) {
  const auto good = Quantize(MakePayload(RoomScan(40), true, true), 0.005);
  ASSERT_TRUE(good.ok());
  const auto refused = [](const PointPayload& bad) {
    return Dequantize(bad).status().code() == absl::StatusCode::kInvalidArgument;
  };
  PointPayload bad = *good;
  bad.width += 1;
  EXPECT_TRUE(refused(bad));
  bad = *good;
  bad.width = bad.height = 0xFFFFFFFF;
  EXPECT_TRUE(refused(bad));
  bad = *good;
  bad.width = 3'999'999;
  bad.stride = 60000;
  EXPECT_TRUE(refused(bad));
  bad = *good;
  std::swap(bad.fields[2], bad.fields[3]);  // Not the order it was made with.
  EXPECT_TRUE(refused(bad));
  bad = *good;
  bad.fields.pop_back();
  EXPECT_TRUE(refused(bad));
  bad = *good;
  bad.fields[4].type = kFloat64;
  EXPECT_TRUE(refused(bad));
  bad = *good;
  bad.resolution_m = 0;
  EXPECT_TRUE(refused(bad));
  bad = *good;
  bad.fields[3].count = 5000;  // Many columns over the same bytes.
  bad.stride = 65536;
  bad.width = 4000;
  EXPECT_TRUE(refused(bad));
}

}  // namespace
}  // namespace isthmus::codec
