#include "core/codec/scan_decoder.h"

#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "core/codec/payload_builder.h"
#include "core/codec/quantized.h"
#include "core/codec/time_field.h"
#include "tests/core/codec/payloads.h"

namespace isthmus::codec {
namespace {

using ::testing::HasSubstr;
using enum ScalarType;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// Four points on a circle, times as given.
PointPayload WithTimes(const std::string& name, ScalarType type, std::vector<double> times) {
  PayloadOf payload(4);
  payload.Add<float>("x", kFloat32, [](uint32_t i) { return 5 + i; })
      .Add<float>("y", kFloat32, [](uint32_t) { return 1; })
      .Add<float>("z", kFloat32, [](uint32_t) { return 0; });
  if (type == kUint32) payload.Add<uint32_t>(name, type, [&](uint32_t i) { return times[i]; });
  if (type == kFloat32) payload.Add<float>(name, type, [&](uint32_t i) { return times[i]; });
  if (type == kFloat64) payload.Add<double>(name, type, [&](uint32_t i) { return times[i]; });
  return payload.Build();
}

void ExpectTimes(const PointPayload& payload, const std::vector<float>& expected) {
  const auto scan = DecodeScan(payload, 1, 2);
  ASSERT_TRUE(scan.ok()) << scan.status();
  ASSERT_TRUE(scan->has_time);
  ASSERT_EQ(scan->points.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(scan->points[i].time, expected[i], 1e-6) << i;
  }
}

TEST(DecodeScan, GivesBackWhatTheBuilderWasGiven) {
  const std::vector<ScanPoint> points = RoomScan();
  const auto scan = DecodeScan(MakePayload(points, true, true), 42, 1'700'000'000'123'456'789);
  ASSERT_TRUE(scan.ok()) << scan.status();
  EXPECT_EQ(scan->sequence, 42u);
  EXPECT_EQ(scan->end_stamp_ns, 1'700'000'000'123'456'789);
  EXPECT_TRUE(scan->has_ring);
  EXPECT_TRUE(scan->has_time);
  ASSERT_EQ(scan->points.size(), points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(scan->points[i].x, points[i].x);
    EXPECT_EQ(scan->points[i].intensity, points[i].intensity);
    EXPECT_EQ(scan->points[i].ring, points[i].ring);
    EXPECT_FLOAT_EQ(scan->points[i].time, points[i].time);
  }
}

TEST(DecodeScan, SaysWhatIsUnknown) {
  const auto scan = DecodeScan(MakePayload(RoomScan(), false, false), 1, 2);
  ASSERT_TRUE(scan.ok()) << scan.status();
  EXPECT_FALSE(scan->has_ring);
  EXPECT_FALSE(scan->has_time);
}

TEST(DecodeScan, ReadsQuantizedPayloads) {
  const std::vector<ScanPoint> points = RoomScan();
  const auto quantized = Quantize(MakePayload(points, true, true), 0.002);
  ASSERT_TRUE(quantized.ok()) << quantized.status();
  const auto scan = DecodeScan(*quantized, 1, 2);
  ASSERT_TRUE(scan.ok()) << scan.status();
  ASSERT_EQ(scan->points.size(), points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(scan->points[i].x, points[i].x, 0.00101);
    EXPECT_EQ(scan->points[i].ring, points[i].ring);
  }
}

TEST(DecodeScan, TellsTheUnitOfTimes) {
  const std::vector<float> expected = {-0.09f, -0.06f, -0.03f, 0};
  ExpectTimes(WithTimes("time", kFloat32, {0, 0.03, 0.06, 0.09}), expected);
  ExpectTimes(WithTimes("time", kFloat32, {-0.09, -0.06, -0.03, 0}), expected);
  ExpectTimes(WithTimes("time", kFloat32, {0, 30e3, 60e3, 90e3}), expected);
  ExpectTimes(WithTimes("t", kUint32, {0, 30e6, 60e6, 90e6}), expected);
  ExpectTimes(WithTimes("offset_time", kUint32, {0, 30e3, 60e3, 90e3}), expected);
  ExpectTimes(WithTimes("time", kFloat64, {0, 30, 60, 90}), expected);
  // Absolute.
  ExpectTimes(WithTimes("timestamp", kFloat64, {1.7e9, 1.7e9 + 0.03, 1.7e9 + 0.06, 1.7e9 + 0.09}),
              expected);
  ExpectTimes(WithTimes("timestamp", kFloat64, {1.7e15, 1.7e15 + 3e4, 1.7e15 + 6e4, 1.7e15 + 9e4}),
              expected);
  // A tenth of a turn.
  ExpectTimes(WithTimes("t", kUint32, {0, 3e6, 6e6, 9e6}), {-0.009f, -0.006f, -0.003f, 0});
  ExpectTimes(WithTimes("time", kFloat32, {0, 3e-3, 6e-3, 9e-3}), {-0.009f, -0.006f, -0.003f, 0});
}

TEST(DecodeScan, KnowsNamesWhoseUnitIsFixed) {
  const std::vector<float> expected = {-0.09f, -0.06f, -0.03f, 0};
  ExpectTimes(WithTimes("time_offset_ns", kUint32, {0, 30e6, 60e6, 90e6}), expected);
  ExpectTimes(WithTimes("curvature", kFloat32, {0, 30, 60, 90}), expected);
  ExpectTimes(WithTimes("curvature", kFloat32, {0, -5e7, 60, 90}), {-0.09f, -0.03f, 0});
  // A part of 2 ms, which in other units would be a turn or nothing.
  ExpectTimes(WithTimes("time_offset_ns", kFloat32, {0, 1e6, 1.5e6, 2e6}),
              {-0.002f, -0.001f, -0.0005f, 0});
  const uint32_t ns[] = {950'000'000, 980'000'000, 10'000'000, 40'000'000};
  PointPayload pair =
      PayloadOf(4)
          .Add<float>("x", kFloat32, [](uint32_t i) { return 5 + i; })
          .Add<float>("y", kFloat32, [](uint32_t) { return 1; })
          .Add<float>("z", kFloat32, [](uint32_t) { return 0; })
          .Add<uint32_t>("timestampSec", kUint32, [](uint32_t i) { return 1.7e9 + (i > 1); })
          .Add<uint32_t>("timestampNsec", kUint32, [&](uint32_t i) { return ns[i]; })
          .Build();
  ExpectTimes(pair, expected);
  ScanDecoder decoder;
  ASSERT_TRUE(decoder.Decode(pair, 1, 2).ok());
  EXPECT_EQ(decoder.fields().time, "field 'timestampSec + timestampNsec' (s, of a clock)");
}

TEST(DecodeScan, AnOddTimeCostsThatPointAndIsCounted) {
  constexpr uint32_t kTimed = 1000;
  ScanDecoder decoder;
  for (int scan = 0; scan < 3; ++scan) {
    const auto payload = PayloadOf(kTimed)
                             .Add<float>("x", kFloat32, [](uint32_t i) { return 5 + 0.01f * i; })
                             .Add<float>("y", kFloat32, [](uint32_t) { return 1; })
                             .Add<float>("z", kFloat32, [](uint32_t) { return 0; })
                             .Add<double>("t", kFloat64,
                                          [&](uint32_t i) {
                                            if (i == 7) return scan == 0 ? 77.0 : double{kNaN};
                                            return 1e-4 * i;
                                          })
                             .Build();
    const auto decoded = decoder.Decode(payload, 1, 2);
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    ASSERT_TRUE(decoded->has_time);
    ASSERT_EQ(decoded->points.size(), kTimed - 1);
    EXPECT_NEAR(decoded->points[6].time, 6e-4 - 0.0999, 1e-6);
    EXPECT_NEAR(decoded->points[7].time, 8e-4 - 0.0999, 1e-6);
    EXPECT_FLOAT_EQ(decoded->points[7].x, 5.08f);
    EXPECT_EQ(decoder.fields().time, absl::StrCat("field 't' (s, from the start of the scan), ",
                                                  scan + 1, " points left out for odd times"));
  }
}

TEST(DecodeScan, TimesThatAreAllZeroSayThatItIsCompensated) {
  PointPayload payload = MakePayload(RoomScan(), true, true);
  ClearTimes(payload);
  ScanDecoder decoder;
  const auto scan = decoder.Decode(payload, 1, 2);
  ASSERT_TRUE(scan.ok()) << scan.status();
  EXPECT_TRUE(scan->has_time);
  for (const ScanPoint& p : scan->points) ASSERT_EQ(p.time, 0);
  EXPECT_EQ(decoder.fields().time, "field 'time' (all 0: motion-compensated already)");
}

TEST(ClearTimes, OverwritesOrAddsTheField) {
  const std::vector<ScanPoint> points = RoomScan();
  for (const bool has_time : {false, true}) {
    PointPayload payload = MakePayload(points, true, has_time);
    ClearTimes(payload);
    EXPECT_EQ(payload.fields.size(), 6u);
    const auto scan = DecodeScan(payload, 1, 2);
    ASSERT_TRUE(scan.ok()) << scan.status();
    EXPECT_TRUE(scan->has_time);
    ASSERT_EQ(scan->points.size(), points.size());
    for (size_t i = 0; i < points.size(); ++i) {
      ASSERT_EQ(scan->points[i].x, points[i].x);
      ASSERT_EQ(scan->points[i].ring, points[i].ring);
      ASSERT_EQ(scan->points[i].time, 0);
    }
  }
  // The field is the one that is read first.
  PointPayload curved = WithTimes("curvature", kFloat32, {0, 30, 60, 90});
  ClearTimes(curved);
  ExpectTimes(curved, {0, 0, 0, 0});
}

TEST(DecodeScan, DoesWithoutTimesThatMakeNoSense) {
  for (const auto& payload :
       {WithTimes("time", kFloat32, {kNaN, kNaN, kNaN, kNaN}),
        WithTimes("time", kFloat32, {0, 1, 2, kNaN}), WithTimes("time", kFloat32, {0, 1, 2, 3}),
        // The curvature of a surface.
        WithTimes("curvature", kFloat32, {0, 0.1, 0.2, 0.3}),
        // Absolute seconds in single precision are all alike.
        WithTimes("timestamp", kFloat32, {1.7e9, 1.7e9 + 0.03, 1.7e9 + 0.06, 1.7e9 + 0.09})}) {
    const auto scan = DecodeScan(payload, 1, 2);
    ASSERT_TRUE(scan.ok()) << scan.status();
    EXPECT_FALSE(scan->has_time);
    EXPECT_EQ(scan->points[0].time, 0);
  }
}

TEST(DecodeScan, DropsNoReturnsAndTheirTimes) {
  const std::vector<float> x = {kNaN, 3, 0, std::numeric_limits<float>::infinity(), 4, 1e30f};
  const auto payload =
      PayloadOf(6)
          .Add<float>("x", kFloat32, [&](uint32_t i) { return x[i]; })
          .Add<float>("y", kFloat32, [](uint32_t) { return 0; })
          .Add<float>("z", kFloat32, [](uint32_t) { return 0; })
          .Add<int16_t>("ring", kInt16, [&](uint32_t i) { return x[i] == 3 || x[i] == 4 ? 2 : -1; })
          .Add<double>("t", kFloat64, [&](uint32_t i) { return i == 0 ? kNaN : i * 0.02; })
          .Build();
  const auto scan = DecodeScan(payload, 1, 2);
  ASSERT_TRUE(scan.ok()) << scan.status();
  ASSERT_EQ(scan->points.size(), 2u);
  EXPECT_EQ(scan->points[0].x, 3);
  EXPECT_EQ(scan->points[1].x, 4);
  EXPECT_EQ(scan->points[1].ring, 2);
  EXPECT_NEAR(scan->points[0].time, -0.06, 1e-6);
}

TEST(DecodeScan, TakesOtherNamesAndTypes) {
  const auto payload = PayloadOf(2)
                           .Add<uint16_t>("reflectivity", kUint16, [](uint32_t i) { return 7 + i; })
                           .Add<double>("z", kFloat64, [](uint32_t i) { return 3.5 + i; })
                           .Add<int32_t>("y", kInt32, [](uint32_t i) { return -2 - int(i); })
                           .Add<int8_t>("x", kInt8, [](uint32_t i) { return 1 + i; })
                           .Add<uint8_t>("line", kUint8, [](uint32_t i) { return i; })
                           .Build();
  const auto scan = DecodeScan(payload, 1, 2);
  ASSERT_TRUE(scan.ok()) << scan.status();
  EXPECT_EQ(scan->points[1].x, 2);
  EXPECT_EQ(scan->points[1].y, -3);
  EXPECT_EQ(scan->points[1].z, 4.5);
  EXPECT_EQ(scan->points[1].intensity, 8);
  EXPECT_TRUE(scan->has_ring);
}

// Organised, 4 rows of 8 columns, elevation of a row in radians given.
PointPayload Organised(const std::function<float(uint32_t)>& elevation, bool ring_field) {
  PayloadOf payload(8, 4);
  payload.Add<float>("x", kFloat32, [](uint32_t i) { return 5 * std::cos(0.7f * (i % 8)); })
      .Add<float>("y", kFloat32, [](uint32_t i) { return 5 * std::sin(0.7f * (i % 8)); })
      .Add<float>("z", kFloat32, [&](uint32_t i) { return 5 * std::tan(elevation(i / 8)); });
  if (ring_field) payload.Add<uint8_t>("ring", kUint8, [](uint32_t i) { return i / 8; });
  return payload.Build();
}

TEST(DecodeScan, TakesRowsForRingsAndTurnsThemRound) {
  const auto rising = [](uint32_t row) { return -0.2f + 0.1f * static_cast<float>(row); };
  const auto falling = [](uint32_t row) { return 0.1f - 0.1f * static_cast<float>(row); };
  for (const bool ring_field : {false, true}) {
    const auto up = DecodeScan(Organised(rising, ring_field), 1, 2);
    ASSERT_TRUE(up.ok()) << up.status();
    EXPECT_TRUE(up->has_ring);
    EXPECT_EQ(up->points.front().ring, 0);
    EXPECT_EQ(up->points.back().ring, 3);
    const auto down = DecodeScan(Organised(falling, ring_field), 1, 2);
    ASSERT_TRUE(down.ok()) << down.status();
    EXPECT_EQ(down->points.front().ring, 3);
    EXPECT_EQ(down->points.back().ring, 0);
  }
}

// The room scan, whose points come firing by firing, as a cloud of so many rows. `by_firing`: as
// it is; else row by row. Every seventh point is no return; all are turned about y by `tilt`.
PointPayload OrganisedRoom(bool by_firing, int columns, float tilt, bool from_top) {
  const std::vector<ScanPoint> room = RoomScan(columns);
  const auto n = static_cast<uint32_t>(columns);
  PayloadOf payload(by_firing ? 16 : n, by_firing ? n : 16);
  const auto laser = [=](uint32_t i) { return by_firing ? i % 16 : i / n; };
  const auto at = [&](uint32_t i) {
    const uint32_t ring = from_top ? 15 - laser(i) : laser(i);
    ScanPoint p = room[(by_firing ? i / 16 : i % n) * 16 + ring];
    if (i % 7 == 0) p.x = kNaN;
    const float x = p.x * std::cos(tilt) + p.z * std::sin(tilt);
    p.z = p.z * std::cos(tilt) - p.x * std::sin(tilt);
    p.x = x;
    return p;
  };
  payload.Add<float>("x", kFloat32, [&](uint32_t i) { return at(i).x; })
      .Add<float>("y", kFloat32, [&](uint32_t i) { return at(i).y; })
      .Add<float>("z", kFloat32, [&](uint32_t i) { return at(i).z; });
  return payload.Build();
}

TEST(DecodeScan, RingsOfOrganisedCloudsAreRowsOrColumns) {
  for (const bool by_firing : {false, true}) {
    for (const int columns : {40, 900, 1800}) {
      for (const bool from_top : {false, true}) {
        const PointPayload payload = OrganisedRoom(by_firing, columns, 0, from_top);
        ScanDecoder decoder;
        const auto scan = decoder.Decode(payload, 1, 2);
        ASSERT_TRUE(scan.ok()) << scan.status();
        ASSERT_TRUE(scan->has_ring) << by_firing << columns;
        EXPECT_EQ(decoder.fields().ring, by_firing ? "columns of the cloud" : "rows of the cloud");
        for (const ScanPoint& p : scan->points) {
          const float elevation = std::atan2(p.z, std::hypot(p.x, p.y)) / 0.0174533f;
          ASSERT_NEAR(elevation, -15 + 2 * p.ring, 0.5);
        }
      }
    }
  }
}

TEST(DecodeScan, RingsOfTiltedOrganisedCloudsAreFound) {
  for (const bool by_firing : {false, true}) {
    ScanDecoder decoder;
    const auto scan = decoder.Decode(OrganisedRoom(by_firing, 900, 0.8f, false), 1, 2);
    ASSERT_TRUE(scan.ok()) << scan.status();
    EXPECT_EQ(decoder.fields().ring, by_firing ? "columns of the cloud" : "rows of the cloud");
  }
}

TEST(DecodeScan, RowsThatAreNoRingsAreNotTakenForSome) {
  // Two returns of every shot, a row each: no row is a ring, and no column sweeps anything.
  const std::vector<ScanPoint> room = RoomScan();
  const auto n = static_cast<uint32_t>(room.size());
  PayloadOf payload(n, 2);
  payload.Add<float>("x", kFloat32, [&](uint32_t i) { return room[i % n].x; })
      .Add<float>("y", kFloat32, [&](uint32_t i) { return room[i % n].y; })
      .Add<float>("z", kFloat32, [&](uint32_t i) { return room[i % n].z; });
  const auto scan = DecodeScan(payload.Build(), 1, 2);
  ASSERT_TRUE(scan.ok()) << scan.status();
  EXPECT_FALSE(scan->has_ring);
}

TEST(DecodeScan, RowsThatAreSectorsOfTheTurnAreNoRings) {
  // Points firing by firing, cut into rows of as many points. 100 rows have 18 whole firings each:
  // there the columns are rings, as each is of one laser all around.
  const std::vector<ScanPoint> room = RoomScan(1800);
  for (const uint32_t rows : {2, 3, 4, 5, 6, 8, 12, 15, 16, 32, 64}) {
    PayloadOf payload(static_cast<uint32_t>(room.size()) / rows, rows);
    payload.Add<float>("x", kFloat32, [&](uint32_t i) { return room[i].x; })
        .Add<float>("y", kFloat32, [&](uint32_t i) { return room[i].y; })
        .Add<float>("z", kFloat32, [&](uint32_t i) { return room[i].z; });
    const auto scan = DecodeScan(payload.Build(), 1, 2);
    ASSERT_TRUE(scan.ok()) << scan.status();
    EXPECT_FALSE(scan->has_ring) << rows;
  }
}

TEST(DecodeScan, RingsOfANarrowViewAreFound) {
  // 40 deg wide, 25 deg high.
  constexpr uint32_t kRows = 32, kColumns = 200;
  PayloadOf payload(kColumns, kRows);
  const auto direction = [](uint32_t i) {
    const double azimuth = (static_cast<double>(i % kColumns) / kColumns - 0.5) * 0.7;
    const double elevation = (static_cast<double>(i / kColumns) / kRows - 0.5) * 0.44;
    return std::pair(azimuth, elevation);
  };
  payload
      .Add<float>("x", kFloat32,
                  [&](uint32_t i) {
                    return 9 * std::cos(direction(i).second) * std::cos(direction(i).first);
                  })
      .Add<float>("y", kFloat32,
                  [&](uint32_t i) {
                    return 9 * std::cos(direction(i).second) * std::sin(direction(i).first);
                  })
      .Add<float>("z", kFloat32, [&](uint32_t i) { return 9 * std::sin(direction(i).second); });
  ScanDecoder decoder;
  ASSERT_TRUE(decoder.Decode(payload.Build(), 1, 2).ok());
  EXPECT_EQ(decoder.fields().ring, "rows of the cloud");
}

TEST(DecodeScan, AFieldThatCountsFromTheTopIsTurnedByItsOwnRings) {
  PointPayload payload = OrganisedRoom(/*by_firing=*/true, 900, 0, /*from_top=*/true);
  payload.fields.push_back({"ring", 12, kUint16});
  payload.stride += 2;
  std::string data;
  for (uint32_t i = 0; i < 900 * 16; ++i) {
    data += payload.data.substr(i * 12, 12);
    data += {static_cast<char>(i % 16), '\0'};
  }
  payload.data = data;
  const auto scan = DecodeScan(payload, 1, 2);
  ASSERT_TRUE(scan.ok()) << scan.status();
  for (const ScanPoint& p : scan->points) {
    const float elevation = std::atan2(p.z, std::hypot(p.x, p.y)) / 0.0174533f;
    ASSERT_NEAR(elevation, -15 + 2 * p.ring, 0.5);
  }
}

void ExpectInvalid(const PointPayload& payload, const std::string& message) {
  const auto scan = DecodeScan(payload, 1, 2);
  EXPECT_EQ(scan.status().code(), absl::StatusCode::kInvalidArgument) << scan.status();
  EXPECT_THAT(std::string(scan.status().message()), HasSubstr(message));
}

TEST(DecodeScan, RefusesScansWithoutPoints) {
  ExpectInvalid(MakePayload(std::vector<ScanPoint>{}, true, true), "empty");
  ExpectInvalid(MakePayload(std::vector<ScanPoint>(10), true, true), "no returns");
}

TEST(DecodeScan, RefusesLyingLayouts) {
  const PointPayload good = MakePayload(RoomScan(), true, true);
  PointPayload bad = good;
  bad.width += 1;
  ExpectInvalid(bad, "do not make");
  bad = good;
  bad.data.pop_back();
  ExpectInvalid(bad, "do not make");
  bad = good;
  bad.width = bad.height = 0xFFFFFFFF;
  ExpectInvalid(bad, "limited to");
  bad = good;
  bad.width = bad.height = 0x80000000;  // The product with stride wraps to 0.
  bad.data.clear();
  ExpectInvalid(bad, "limited to");
  bad = good;
  bad.stride = 0;
  ExpectInvalid(bad, "stride");
  bad = good;
  bad.fields[0].offset = 0xFFFFFFFF;
  ExpectInvalid(bad, "'x'");
  bad = good;
  bad.fields[1].count = 0x40000001;
  ExpectInvalid(bad, "'y'");
  bad = good;
  bad.fields[2].type = static_cast<ScalarType>(99);
  ExpectInvalid(bad, "'z'");
  bad = good;
  bad.fields[2].name = "height";
  ExpectInvalid(bad, "x, y and z");
  bad = good;
  bad.fields.clear();
  ExpectInvalid(bad, "fields");
}

TEST(DecodeScan, RefusesRingsThatAreNone) {
  PointPayload bad = MakePayload(RoomScan(), true, true);
  bad.fields[4].type = kInt16;
  bad.data.replace(bad.fields[4].offset, 2, "\xFF\xFF");
  ExpectInvalid(bad, "ring");
}

}  // namespace
}  // namespace isthmus::codec
