#include "core/map/submap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace isthmus {
namespace {

TEST(Box, IsEmptyUntilExtended) {
  Box box;
  EXPECT_TRUE(box.empty());
  box.Extend(Eigen::Vector3d(1, 2, 3));
  EXPECT_FALSE(box.empty());
  EXPECT_TRUE(box.Contains({1, 2, 3}));
  EXPECT_FALSE(box.Contains({1, 2, 3.001}));
  Box other;
  other.Extend(box);
  other.Extend(Box());
  EXPECT_EQ(other.min, box.min);
  EXPECT_EQ(other.max, box.max);
}

TEST(Box, IntersectsWhenItTouches) {
  Box a, b;
  a.Extend(Eigen::Vector3d(0, 0, 0));
  a.Extend(Eigen::Vector3d(1, 1, 1));
  b.Extend(Eigen::Vector3d(1, 0.5, 0.5));
  b.Extend(Eigen::Vector3d(2, 2, 2));
  EXPECT_TRUE(a.Intersects(b));
  b.min.x() = 1.0001;
  EXPECT_FALSE(a.Intersects(b));
  EXPECT_FALSE(a.Intersects(Box()));
}

TEST(Summarize, TellsAllButThePoints) {
  Submap submap;
  submap.id = {SessionId("alice-1"), 7};
  submap.robot = RobotId("alice");
  submap.T_odom_submap = Pose::FromXyzRpy(1, 2, 3, 0, 0, 1);
  submap.first_sequence = 11;
  submap.last_sequence = 20;
  submap.first_stamp_ns = 100;
  submap.last_stamp_ns = 200;
  submap.keyframes.resize(3);
  submap.points = {{1, 5, -2, 0, 0}, {-3, 2, 4, 0, 1}, {0, 0, 0, 0, 2}};
  const SubmapInfo info = Summarize(submap);
  EXPECT_EQ(info.id, submap.id);
  EXPECT_EQ(info.robot, submap.robot);
  EXPECT_EQ(info.first_sequence, 11u);
  EXPECT_EQ(info.last_sequence, 20u);
  EXPECT_EQ(info.first_stamp_ns, 100);
  EXPECT_EQ(info.last_stamp_ns, 200);
  EXPECT_EQ(info.keyframe_count, 3u);
  EXPECT_EQ(info.point_count, 3u);
  EXPECT_EQ(info.bounds.min, Eigen::Vector3d(-3, 0, -2));
  EXPECT_EQ(info.bounds.max, Eigen::Vector3d(1, 5, 4));
  submap.points.clear();
  EXPECT_TRUE(Summarize(submap).bounds.empty());
}

TEST(Transform, BoundsEveryPointOfTheBoxTightly) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(0, 1);
  Box box;
  box.Extend(Eigen::Vector3d(-1, 2, -3));
  box.Extend(Eigen::Vector3d(4, 5, 6));
  const Pose T = Pose::FromXyzRpy(7, -8, 9, 0.3, -0.7, 2.1);
  const Box moved = Transform(T, box);
  Box seen;
  for (int i = 0; i < 1000; ++i) {
    // Corners and points within.
    Eigen::Vector3d p;
    for (int axis = 0; axis < 3; ++axis) {
      const double u = i < 8 ? (i >> axis & 1) : unit(random);
      p[axis] = box.min[axis] + u * (box.max[axis] - box.min[axis]);
    }
    EXPECT_TRUE(moved.Contains(T * p) || i < 8);
    seen.Extend(T * p);
  }
  EXPECT_LT((seen.min - moved.min).norm() + (seen.max - moved.max).norm(), 1e-12);
  EXPECT_TRUE(Transform(T, Box()).empty());
}

}  // namespace
}  // namespace isthmus
