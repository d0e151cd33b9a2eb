#include "floam/scan/undistort.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/floam/room.h"

namespace isthmus::floam {
namespace {

using testing::FurnishedRoom;
using testing::MakeScan;
using testing::Room;
using testing::Sensor;

const Vector6d kTwist = (Vector6d() << 2.1, -0.3, 0.1, 0.05, -0.1, 1.2).finished();

TEST(ScanMotion, IsTheExponentialOfTheTwist) {
  const ScanMotion motion(kTwist, -0.05, -0.1, 0);
  const Eigen::Vector3d p(60, -40, 5);
  for (double t = -0.1; t <= 0; t += 0.0037) {
    const Eigen::Vector3d exact = Exp((t + 0.05) * kTwist) * p;
    const Eigen::Vector3f fast = motion.ToReference(p.cast<float>(), static_cast<float>(t));
    EXPECT_LT((exact - fast.cast<double>()).norm(), 2e-4) << t;
  }
}

TEST(ScanMotion, MovesTimesOutsideToTheEnds) {
  const ScanMotion motion(kTwist, 0, -0.1, 0);
  const Eigen::Vector3f p(1, 2, 3);
  EXPECT_EQ(motion.ToReference(p, 5.F), motion.ToReference(p, 0.F));
  EXPECT_EQ(motion.ToReference(p, -5.F), motion.ToReference(p, -0.1F));
}

// Points of a scan taken in motion lie, once undistorted, on the walls as seen from its END.
TEST(Undistort, BringsPointsBackOntoTheWorld) {
  const Room room = FurnishedRoom();
  Sensor sensor;
  sensor.noise_m = 0;
  const auto motion = [](double time_s) {
    return Pose::FromXyzRpy(-1, 2.5, 0, 0, 0, 0.3) * Exp(time_s * kTwist);
  };
  const Scan scan = MakeScan(room, motion, sensor, 0);
  RingScan sorted;
  ASSERT_TRUE(RingSorter().Sort(scan, *FindSensorModel("vlp16"), 0.1, &sorted).ok());
  Cloud cloud;
  Undistort(sorted, ScanMotion(kTwist, 0, -0.1, 0), &cloud);
  ASSERT_EQ(cloud.size(), scan.points.size());
  const Pose T_world_end = EndPose(motion, sensor, 0);
  double moved = 0;
  for (size_t i = 0; i < cloud.size(); ++i) {
    const RingPoint& p = sorted.points[i];
    // The point as it was measured, in the world.
    const Eigen::Vector3d truth = motion(0.1 + p.time) * Eigen::Vector3d(p.x, p.y, p.z);
    const Eigen::Vector3d fixed = T_world_end * cloud[i].Position().cast<double>();
    EXPECT_LT((fixed - truth).norm(), 1e-4);
    moved = std::max<double>(moved, (cloud[i].Position() - Eigen::Vector3f(p.x, p.y, p.z)).norm());
  }
  EXPECT_GT(moved, 0.5) << "the motion was too small to show anything";
}

}  // namespace
}  // namespace isthmus::floam
