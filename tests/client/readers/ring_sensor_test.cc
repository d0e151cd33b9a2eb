#include "client/readers/ring_sensor.h"

#include <gtest/gtest.h>

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
