#include "server/classes/moments.h"

#include <gtest/gtest.h>

#include "tests/server/classes/clouds.h"

namespace isthmus::classes {
namespace {

TEST(MomentsTest, APlaneIsPlanarWithItsNormalUp) {
  Moments moments(RoomFloor());
  for (int level = 0; level < kLevels; ++level) {
    const Shape shape = moments.At(level, {6, 4, 0});
    EXPECT_GT(shape.planar, 0.7F) << level;
    EXPECT_LT(shape.scattered, 0.1F) << level;
    EXPECT_GT(shape.normal_z, 0.99F) << level;
    EXPECT_LT(shape.thickness_m, 0.01F) << level;
  }
}

TEST(MomentsTest, AnUprightLineIsLinearAlongUp) {
  Cloud3 pole;
  for (float z = 0; z < 4; z += 0.05F) pole.push_back({1, 1, z});
  Moments moments(pole);
  const Shape shape = moments.At(2, {1, 1, 2});
  EXPECT_GT(shape.linear, 0.99F);
  EXPECT_GT(shape.along_z, 0.99F);
}

TEST(MomentsTest, APointCloudFarFromTheOriginHasTheSameShape) {
  const Eigen::Vector3f far(5000, -3000, 100);
  Cloud3 moved;
  for (const Eigen::Vector3f& p : RoomWalls()) moved.push_back(p + far);
  Moments here(RoomWalls()), there(moved);
  const Shape a = here.At(2, {6, 0, 1.5F}), b = there.At(2, far + Eigen::Vector3f(6, 0, 1.5F));
  EXPECT_NEAR(a.planar, b.planar, 0.05F);
  EXPECT_NEAR(a.normal_z, b.normal_z, 0.05F);
}

TEST(MomentsTest, NoShapeWhereNothingIs) {
  Moments moments(RoomFloor());
  EXPECT_EQ(moments.At(0, {6, 4, 2}).cells, 0);
  Moments none(Cloud3{});
  EXPECT_EQ(none.At(3, {0, 0, 0}).cells, 0);
  Moments one(Cloud3{{1, 2, 3}});
  EXPECT_EQ(one.At(0, {1, 2, 3}).cells, 1);
  EXPECT_EQ(one.At(0, {1, 2, 3}).planar, 0);
  Moments same(Cloud3(10, {1, 2, 3}));
  EXPECT_EQ(same.At(0, {1, 2, 3}).linear, 0);
}

}  // namespace
}  // namespace isthmus::classes
