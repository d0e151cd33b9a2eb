#include "core/codec/draco_cloud.h"

#include <absl/strings/string_view.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "core/byte_stream.h"
#include "core/codec/payload_builder.h"
#include "core/codec/payload_layout.h"
#include "core/codec/quantized.h"
#include "tests/core/codec/payloads.h"

namespace isthmus::codec {
namespace {

using ::testing::HasSubstr;
using enum ScalarType;

constexpr double kStepM = 0.001;

using Place = std::function<std::array<float, 3>(uint32_t)>;

// Laid out as points of the map. Intensities are any bits at all.
PointPayload MapOf(uint32_t n, const Place& place) {
  std::vector<std::array<float, 3>> places;
  for (uint32_t i = 0; i < n; ++i) places.push_back(place(i));
  std::mt19937 random(5);
  return PayloadOf(n)
      .Add<float>("x", kFloat32, [&](uint32_t i) { return places[i][0]; })
      .Add<float>("y", kFloat32, [&](uint32_t i) { return places[i][1]; })
      .Add<float>("z", kFloat32, [&](uint32_t i) { return places[i][2]; })
      .Add<uint32_t>("intensity", kFloat32,
                     [&](uint32_t) { return static_cast<uint32_t>(random()); })
      .Add<uint32_t>("robot", kUint32, [](uint32_t i) { return i % 3; })
      .Add<uint32_t>("last_seen", kUint32, [](uint32_t i) { return 4'000'000'000u + i / 50; })
      .Build();
}

// A spiral that rises, through the origin's neighbourhood.
std::array<float, 3> Spiral(uint32_t i) {
  const float turn = 0.01f * static_cast<float>(i);
  return {turn * std::cos(turn), turn * std::sin(turn), turn / 50 - 3};
}

// Points as records, in an order that does not depend on the one they came in.
std::vector<absl::string_view> Sorted(const PointPayload& raw) {
  std::vector<absl::string_view> records;
  for (size_t at = 0; at < raw.data.size(); at += raw.stride) {
    records.push_back(absl::string_view(raw.data).substr(at, raw.stride));
  }
  std::sort(records.begin(), records.end());
  return records;
}

PointPayload ByDraco(const PointPayload& raw, double step_m = kStepM) {
  const auto packed = PackDraco(raw, step_m);
  EXPECT_TRUE(packed.ok()) << packed.status();
  if (!packed.ok()) return {};
  const auto back = UnpackDraco(*packed);
  EXPECT_TRUE(back.ok()) << back.status();
  return back.value_or(PointPayload());
}

// Bit by bit, every point with its own fields.
void ExpectAsQuantized(const PointPayload& raw, double step_m = kStepM) {
  const auto quantized = Quantize(raw, step_m);
  ASSERT_TRUE(quantized.ok()) << quantized.status();
  const auto expected = Dequantize(*quantized);
  ASSERT_TRUE(expected.ok()) << expected.status();
  const PointPayload back = ByDraco(raw, step_m);
  EXPECT_TRUE(Sorted(back) == Sorted(*expected));
}

TEST(DracoCloud, HasThePointsOfAQuantizedCloud) {
  for (const double step_m : {1e-5, 0.001, 0.1}) ExpectAsQuantized(MapOf(5000, Spiral), step_m);
}

TEST(DracoCloud, KeepsCoordinatesWithinHalfAStep) {
  // The intensity tells which point it is.
  PointPayload raw = MakePayload(Cloud(4000));
  for (uint32_t i = 0; i < 4000; ++i) {
    std::string record;
    for (const float value : Spiral(i)) AppendBytes(value, record);
    AppendBytes(static_cast<float>(i), record);
    raw.data.replace(i * raw.stride, raw.stride, record);
  }
  const PointPayload back = ByDraco(raw, 0.01);
  ASSERT_EQ(back.data.size(), raw.data.size());
  const auto x = ReadColumn(back, back.fields[0]), z = ReadColumn(back, back.fields[2]),
             which = ReadColumn(back, back.fields[3]);
  for (size_t i = 0; i < which.size(); ++i) {
    const auto place = Spiral(static_cast<uint32_t>(which[i]));
    EXPECT_NEAR(x[i], place[0], 0.005 + 1e-5);
    EXPECT_NEAR(z[i], place[2], 0.005 + 1e-5);
  }
}

TEST(DracoCloud, TakesFewPointsAndManyAtOnePlace) {
  ExpectAsQuantized(MapOf(1, Spiral));
  ExpectAsQuantized(MapOf(2, Spiral));
  const auto origin = [](uint32_t) { return std::array<float, 3>{}; };
  const auto corner = [](uint32_t) { return std::array<float, 3>{-7.5f, 1e5f, 0.25f}; };
  ExpectAsQuantized(MapOf(1, origin));
  ExpectAsQuantized(MapOf(3000, origin));
  ExpectAsQuantized(MapOf(3000, corner));
  // Nothing that differs.
  ExpectAsQuantized(MakePayload(Cloud(1000)));
  ExpectAsQuantized(MakePayload(Cloud(1000, {1, 2, 3, 4})));
  PointPayload none = MapOf(1, origin);
  none.width = 0;
  none.data.clear();
  EXPECT_EQ(PackDraco(none, kStepM).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(DracoCloud, TakesAMillionPoints) { ExpectAsQuantized(MapOf(1'000'000, Spiral)); }

TEST(DracoCloud, TakesAsManyFieldsAsItSays) {
  PointPayload raw = MapOf(300, Spiral);
  const uint32_t robots = raw.fields[4].offset;
  while (raw.fields.size() < 3 + kMaxDracoFields) raw.fields.push_back({"again", robots, kUint32});
  ExpectAsQuantized(raw);
  raw.fields.push_back({"again", robots, kUint32});
  const auto status = PackDraco(raw, kStepM).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("at most 12 fields"));
}

TEST(DracoCloud, IsSmallerThanAQuantizedCloud) {
  // A floor at the voxels of a map, which follow each other as they were met.
  std::mt19937 random(1);
  std::uniform_real_distribution<float> within(0, 0.1f);
  PointPayload raw = MapOf(40'000, [&](uint32_t i) {
    const uint32_t voxel = i * 7919 % 40'000;
    return std::array<float, 3>{0.1f * static_cast<float>(voxel % 200) + within(random),
                                0.1f * static_cast<float>(voxel / 200) + within(random),
                                0.2f * within(random)};
  });
  raw.fields.resize(3);
  const auto by_draco = PackDraco(raw, kStepM);
  const auto quantized = Quantize(raw, kStepM);
  ASSERT_TRUE(by_draco.ok() && quantized.ok());
  EXPECT_LT(by_draco->data.size(), quantized->data.size());
}

TEST(DracoCloud, RefusesWhatItCannotKeep) {
  const auto refused = [](const PointPayload& raw, const char* why, double step_m = kStepM) {
    const absl::Status status = PackDraco(raw, step_m).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(status.message()), HasSubstr(why));
  };
  const PointPayload good = MapOf(10, Spiral);
  for (const double step_m : {0.0, 1e-6, 0.2, std::nan("")}) refused(good, "resolution", step_m);
  refused(*PackDraco(good, kStepM), "compressed already");
  refused(MapOf(10, [](uint32_t) { return std::array<float, 3>{0, 1e6f, 0}; }), "beyond");
  for (const float value : {std::nanf(""), std::numeric_limits<float>::infinity()}) {
    refused(MapOf(10,
                  [&](uint32_t i) {
                    return std::array<float, 3>{i == 7 ? value : 0, 0, 0};
                  }),
            "not finite");
  }
  refused(MakePayload(RoomScan(4), true, true), "'ring' is 1 of uint16");
  PointPayload nameless = good;
  nameless.fields[1].name = "";
  refused(nameless, "no field 'y'");
  EXPECT_EQ(UnpackDraco(good).status().code(), absl::StatusCode::kInvalidArgument);
}

// Nothing is decoded, and nothing allocated, for other numbers of points, fields or attributes than
// the message says.
TEST(DracoCloud, RefusesLyingHeaders) {
  const auto good = PackDraco(MapOf(500, Spiral), kStepM);
  ASSERT_TRUE(good.ok());
  const auto refused = [](const PointPayload& bad) {
    EXPECT_EQ(UnpackDraco(bad).status().code(), absl::StatusCode::kInvalidArgument);
  };
  PointPayload bad = *good;
  for (const uint32_t width : {0u, 1u, 499u, 501u, 3'999'999u, 0xFFFFFFFFu}) {
    bad.width = width;
    refused(bad);
  }
  bad = *good;
  bad.height = 0xFFFFFFFF;
  refused(bad);
  bad = *good;
  bad.fields.pop_back();
  refused(bad);
  bad = *good;
  bad.fields.push_back(bad.fields.back());
  refused(bad);
  bad = *good;
  bad.resolution_m = 0;
  refused(bad);
  // Both counts of points, and all descriptions of attributes; only the width of numbers may vary.
  const size_t width_at = 11 + 4 + 1 + 1 + 4 * 5 + 1;
  for (size_t i = 0; i < width_at + 8; ++i) {
    if (i >= width_at && i < width_at + 4) continue;
    for (int bit = 0; bit < 8; ++bit) {
      bad = *good;
      bad.data[i] = static_cast<char>(bad.data[i] ^ (1 << bit));
      refused(bad);
    }
  }
}

TEST(DracoCloud, RefusesWhatEndsEarly) {
  const auto good = PackDraco(MapOf(300, Spiral), kStepM);
  ASSERT_TRUE(good.ok());
  for (size_t i = 0; i < good->data.size(); ++i) {
    PointPayload bad = *good;
    bad.data.resize(i);
    ASSERT_EQ(UnpackDraco(bad).status().code(), absl::StatusCode::kInvalidArgument) << i;
  }
  PointPayload longer = *good;
  longer.data.push_back('\0');
  EXPECT_EQ(UnpackDraco(longer).status().code(), absl::StatusCode::kInvalidArgument);
}

// Damage may go unnoticed; but as many points come, or none.
TEST(DracoCloud, SurvivesDamage) {
  const auto good = PackDraco(MapOf(300, Spiral), kStepM);
  ASSERT_TRUE(good.ok());
  const auto survives = [&](const PointPayload& bad) {
    const auto back = UnpackDraco(bad);
    if (!back.ok()) return back.status().code() == absl::StatusCode::kInvalidArgument;
    return back->data.size() == size_t{300} * good->stride;
  };
  for (size_t i = 0; i < good->data.size(); ++i) {
    PointPayload bad = *good;
    bad.data[i] = static_cast<char>(bad.data[i] ^ (1 << i % 8));
    ASSERT_TRUE(survives(bad)) << i;
  }
  std::mt19937 random(3);
  for (int trial = 0; trial < 1000; ++trial) {
    PointPayload bad = *good;
    const size_t from = 45 + random() % (bad.data.size() - 45);
    for (size_t i = from; i < bad.data.size() && i < from + 1 + random() % 64; ++i) {
      bad.data[i] = static_cast<char>(random());
    }
    ASSERT_TRUE(survives(bad)) << trial;
  }
}

}  // namespace
}  // namespace isthmus::codec
