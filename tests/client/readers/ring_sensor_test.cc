#include "client/readers/ring_sensor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/codec/payload_builder.h"

namespace isthmus::readers {
namespace {

PointPayload WithRings(uint16_t highest) {
  std::vector<ScanPoint> points(2);
  points[1].ring = highest;
  return codec::MakePayload(points, /*has_ring=*/true, /*has_time=*/false);
}

TEST(RingSensorTest, TakesTheSmallestModelWithSoManyRings) {
  RingSensor sensor;
  EXPECT_EQ(sensor.sensor(), "");
  sensor.Look(WithRings(15));
  EXPECT_EQ(sensor.sensor(), "vlp16");
  sensor.Look(WithRings(16));
  EXPECT_EQ(sensor.sensor(), "hdl32");
  sensor.Look(WithRings(2));
  EXPECT_EQ(sensor.sensor(), "hdl32");
  sensor.Look(WithRings(127));
  EXPECT_EQ(sensor.sensor(), "os1-128");
}

TEST(RingSensorTest, FiringsOfAnOrganisedCloudAreNoRings) {
  // 100 firings of 32 lasers, a row each.
  std::vector<ScanPoint> points;
  for (int i = 0; i < 3200; ++i) {
    const double azimuth = 0.0628 * (i / 32), elevation = -0.4 + 0.02 * (i % 32);
    ScanPoint p;
    p.x = static_cast<float>(9 * std::cos(azimuth));
    p.y = static_cast<float>(9 * std::sin(azimuth));
    p.z = static_cast<float>(9 * std::tan(elevation));
    points.push_back(p);
  }
  PointPayload payload = codec::MakePayload(points, /*has_ring=*/false, /*has_time=*/false);
  payload.width = 32;
  payload.height = 100;
  RingSensor sensor;
  sensor.Look(payload);
  EXPECT_EQ(sensor.sensor(), "hdl32");
}

TEST(RingSensorTest, LivoxIsToldByItsFields) {
  RingSensor sensor;
  PointPayload payload = WithRings(3);
  payload.fields.push_back({"tag", 16, ScalarType::kUint8});
  payload.fields.push_back({"line", 17, ScalarType::kUint8});
  sensor.Look(payload);
  EXPECT_EQ(sensor.sensor(), "livox");
}

}  // namespace
}  // namespace isthmus::readers
