#include "floam/rings/ring_scan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "core/geometry/angles.h"
#include "tests/floam/room.h"

namespace isthmus::floam {
namespace {

using testing::FurnishedRoom;
using testing::MakeScan;
using testing::Sensor;
using testing::Still;

SensorModel Vlp16() { return *FindSensorModel("vlp16"); }

Scan ScanOfRoom() { return MakeScan(FurnishedRoom(), Still, Sensor(), 0); }

// As a KITTI file: one ring after the other from the top, each counter-clockwise from +x.
Scan RingMajor(const Scan& scan) {
  Scan sorted = scan;
  std::stable_sort(sorted.points.begin(), sorted.points.end(),
                   [](const ScanPoint& a, const ScanPoint& b) {
                     const auto turn = [](const ScanPoint& p) {
                       const double azimuth = std::atan2(p.y, p.x);
                       return azimuth < 0 ? azimuth + 2 * M_PI : azimuth;
                     };
                     if (a.ring != b.ring) return a.ring > b.ring;
                     return turn(a) < turn(b);
                   });
  return sorted;
}

Scan Stripped(Scan scan) {
  scan.has_ring = scan.has_time = false;
  for (ScanPoint& p : scan.points) p.ring = 0, p.time = 0;
  return scan;
}

// Expects that each ring of `truth` is one ring of `sorted`, and that times agree within a column.
void ExpectSameRingsAndTimes(const Scan& truth, const RingScan& sorted, double tolerance_s) {
  const auto key = [](float x, float y, float z) { return std::make_tuple(x, y, z); };
  std::map<std::tuple<float, float, float>, const ScanPoint*> by_position;
  for (const ScanPoint& p : truth.points) by_position[key(p.x, p.y, p.z)] = &p;
  int rings = 0;
  double worst_s = 0;
  for (size_t ring = 0; ring + 1 < sorted.ring_begin.size(); ++ring) {
    std::set<int> seen;
    for (uint32_t i = sorted.ring_begin[ring]; i < sorted.ring_begin[ring + 1]; ++i) {
      const RingPoint& p = sorted.points[i];
      const ScanPoint* original = by_position.at(key(p.x, p.y, p.z));
      seen.insert(original->ring);
      worst_s = std::max<double>(worst_s, std::abs(original->time - p.time));
    }
    EXPECT_LE(seen.size(), 1u) << "ring " << ring;
    rings += seen.empty() ? 0 : 1;
  }
  EXPECT_EQ(sorted.points.size(), truth.points.size());
  EXPECT_EQ(rings, 16);
  EXPECT_LT(worst_s, tolerance_s);
}

TEST(RingScan, TakesTheSensorsOwnRingsAndTimes) {
  const Scan scan = ScanOfRoom();
  RingScan sorted;
  ASSERT_TRUE(RingSorter().Sort(scan, Vlp16(), 0.1, &sorted).ok());
  EXPECT_EQ(sorted.rings_from, Inference::kSensor);
  EXPECT_EQ(sorted.times_from, Inference::kSensor);
  ExpectSameRingsAndTimes(scan, sorted, 1e-9);
}

TEST(RingScan, InfersRingsByElevationAndTimesByFiringOrder) {
  const Scan scan = ScanOfRoom();
  RingScan sorted;
  ASSERT_TRUE(RingSorter().Sort(Stripped(scan), Vlp16(), 0.1, &sorted).ok());
  EXPECT_EQ(sorted.rings_from, Inference::kSensorModel);
  EXPECT_EQ(sorted.times_from, Inference::kPointOrder);
  ExpectSameRingsAndTimes(scan, sorted, 2e-4);
}

TEST(RingScan, InfersRingsByWrapAndTimesByTheModelsTurnFromSortedFiles) {
  const Scan scan = ScanOfRoom();
  SensorModel model = Vlp16();
  model.sorted_files = true;
  RingScan sorted;
  ASSERT_TRUE(RingSorter().Sort(Stripped(RingMajor(scan)), model, 0.1, &sorted).ok());
  EXPECT_EQ(sorted.rings_from, Inference::kPointOrder);
  EXPECT_EQ(sorted.times_from, Inference::kSensorModel);
  // The very first column lies on the seam: it may be taken for the last.
  Scan off_seam = RingMajor(scan);
  std::erase_if(off_seam.points, [](const ScanPoint& p) { return p.time < -0.0999F; });
  ASSERT_TRUE(RingSorter().Sort(Stripped(off_seam), model, 0.1, &sorted).ok());
  ExpectSameRingsAndTimes(off_seam, sorted, 2e-4);
}

TEST(RingScan, FindsRingsOfAnUnknownSensorFromTheHistogram) {
  Sensor sensor;
  sensor.lowest_rad = -0.4;
  sensor.highest_rad = 0.1;
  const Scan scan = MakeScan(FurnishedRoom(), Still, sensor, 0);
  SensorModel unknown;
  RingScan sorted;
  ASSERT_TRUE(RingSorter().Sort(Stripped(scan), unknown, 0.1, &sorted).ok());
  EXPECT_EQ(sorted.rings_from, Inference::kHistogram);
  ExpectSameRingsAndTimes(scan, sorted, 2e-4);
}

TEST(RingScan, RefusesWhatCannotBeUsed) {
  const auto code = [](const Scan& scan) {
    RingScan sorted;
    return RingSorter().Sort(scan, Vlp16(), 0.1, &sorted).code();
  };
  const Scan good = ScanOfRoom();
  EXPECT_EQ(code(good), absl::StatusCode::kOk);
  EXPECT_EQ(code(Scan()), absl::StatusCode::kInvalidArgument);
  Scan bad = good;
  bad.points[77].y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(code(bad), absl::StatusCode::kInvalidArgument);
  bad.points[77].y = std::numeric_limits<float>::infinity();
  EXPECT_EQ(code(bad), absl::StatusCode::kInvalidArgument);
  bad = good;
  for (ScanPoint& p : bad.points) p.x = 3, p.y = 1, p.z = 0;
  EXPECT_EQ(code(bad), absl::StatusCode::kInvalidArgument);
  bad = good;
  for (ScanPoint& p : bad.points) p.x *= 1e-3F, p.y *= 1e-3F, p.z *= 1e-3F;
  EXPECT_EQ(code(bad), absl::StatusCode::kInvalidArgument);
  bad = good;
  bad.points[5].time = 0.5F;
  EXPECT_EQ(code(bad), absl::StatusCode::kInvalidArgument);
}

TEST(Azimuth, IsExactToTenMicroradians) {
  for (int k = -3600; k <= 3600; ++k) {
    const double angle = k * M_PI / 3600 * 0.9999;
    const auto y = static_cast<float>(7 * std::sin(angle));
    const auto x = static_cast<float>(7 * std::cos(angle));
    EXPECT_NEAR(FastAtan2(y, x), std::atan2(y, x), 1.5e-5);
  }
  EXPECT_EQ(FastAtan2(0, 0), 0);
}

}  // namespace
}  // namespace isthmus::floam
