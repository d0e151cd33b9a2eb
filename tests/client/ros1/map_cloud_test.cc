#include "client/ros1/map_cloud.h"

#include <gtest/gtest.h>

#include <cstring>

namespace isthmus::ros1 {
namespace {

TEST(Ros1MapCloud, HoldsThePointsOfAllChunks) {
  MapCloud cloud(3);
  EXPECT_TRUE(cloud.Add({4, {}, {{1, 2, 3, 0.5F, 0}, {4, 5, 6, 0.5F, 1}}}));
  EXPECT_TRUE(cloud.Add({4, {}, {{7, 8, 9, 0.5F, 2}}}));
  EXPECT_EQ(cloud.revision(), 4);
  const sensor_msgs::PointCloud2 message = cloud.Take("map", ros::Time(3, 0));
  EXPECT_EQ(message.header.frame_id, "map");
  EXPECT_EQ(message.width, 3U);
  ASSERT_EQ(message.data.size(), message.row_step);
  ASSERT_EQ(message.fields.back().name, "robot");
  uint32_t robot = 0;
  std::memcpy(&robot, &message.data[2 * message.point_step + message.fields.back().offset], 4);
  EXPECT_EQ(robot, 2U);
}

TEST(Ros1MapCloud, SaysWhenThereAreTooMany) {
  MapCloud cloud(1);
  EXPECT_FALSE(cloud.Add({1, {}, {{}, {}}}));
  EXPECT_TRUE(cloud.is_full());
}

}  // namespace
}  // namespace isthmus::ros1
