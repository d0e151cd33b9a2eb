#include "floam/scan/ring_chords.h"

#include <gtest/gtest.h>

#include <cmath>

#include "floam/scan/features.h"
#include "tests/floam/room.h"

namespace isthmus::floam {
namespace {

class RingChordsTest : public ::testing::Test {
 protected:
  RingChordsTest() {
    const Scan scan = testing::MakeScan(
        testing::Room(), [](double) { return Pose(); }, testing::Sensor(), 0);
    EXPECT_TRUE(RingSorter().Sort(scan, *FindSensorModel("vlp16"), 0.1, &scan_).ok());
  }

  // The point a third of the way along a ring.
  TimedPoint PointOn(int ring) const {
    const uint32_t begin = scan_.ring_begin[ring], end = scan_.ring_begin[ring + 1];
    const RingPoint& p = scan_.points[begin + (end - begin) / 3];
    TimedPoint point;
    point.position = p.Position();
    point.time = p.time;
    point.ring = static_cast<uint16_t>(ring);
    return point;
  }

  RingScan scan_;
  Work work_;
};

// The rings that hit a wall between others on it point up and down.
TEST_F(RingChordsTest, LieAlongTheWall) {
  for (int ring = 0; ring < 16; ++ring) {
    const TimedPoint point = PointOn(ring);
    if (std::abs(point.position.z()) > 0.8F) continue;  // The floor begins beside it.
    const RingChords chords = ChordsOf(scan_, {point}, &work_).front();
    int known = 0;
    for (const Eigen::Vector3f& chord : chords) {
      if (chord.isZero()) continue;
      ++known;
      EXPECT_NEAR(chord.norm(), 1, 1e-5);
      EXPECT_GT(std::abs(chord.z()), 0.9F) << ring;
    }
    EXPECT_GE(known, 1) << ring;
    const Eigen::Vector3f wall =
        std::abs(point.position.y()) > 6.9F ? Eigen::Vector3f::UnitY() : Eigen::Vector3f::UnitX();
    EXPECT_TRUE(MayBe(chords, wall));
    EXPECT_FALSE(MayBe(chords, (wall + Eigen::Vector3f::UnitZ()).normalized()));
  }
}

TEST_F(RingChordsTest, OnEitherSideOfWhichOneIsEnough) {
  const Eigen::Vector3f x = Eigen::Vector3f::UnitX(), z = Eigen::Vector3f::UnitZ();
  EXPECT_TRUE(MayBe({z, x}, x));   // A wall above the floor.
  EXPECT_TRUE(MayBe({x, z}, x));   // The floor's end.
  EXPECT_FALSE(MayBe({x, x}, x));  // Floor on both sides.
  EXPECT_FALSE(MayBe({x, Eigen::Vector3f::Zero()}, x));
}

TEST_F(RingChordsTest, WhereNothingIsBesideAnythingMayBe) {
  const Eigen::Vector3f none = Eigen::Vector3f::Zero();
  EXPECT_TRUE(MayBe({none, none}, Eigen::Vector3f::UnitX()));
}

// Somebody stands before the wall where the next rings go: it may go on behind.
TEST_F(RingChordsTest, BehindWhatIsNearerAnythingMayBe) {
  const TimedPoint point = PointOn(8);
  for (const int ring : {6, 7, 9, 10}) {
    for (uint32_t i = scan_.ring_begin[ring]; i < scan_.ring_begin[ring + 1]; ++i) {
      RingPoint& p = scan_.points[i];
      p.x *= 0.3F, p.y *= 0.3F, p.z *= 0.3F, p.range *= 0.3F;
    }
  }
  const RingChords chords = ChordsOf(scan_, {point}, &work_).front();
  EXPECT_TRUE(chords[0].hasNaN() && chords[1].hasNaN());
  EXPECT_TRUE(MayBe(chords, Eigen::Vector3f(1, 1, 1).normalized()));
}

TEST_F(RingChordsTest, WithoutRingsThereAreNone) {
  const TimedPoint point = PointOn(8);
  scan_.rings_from = Inference::kNone;
  EXPECT_TRUE(ChordsOf(scan_, {point}, &work_).empty());
}

}  // namespace
}  // namespace isthmus::floam
