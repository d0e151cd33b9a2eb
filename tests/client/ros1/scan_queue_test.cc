#include "client/ros1/scan_queue.h"

#include <gtest/gtest.h>

#include "client/ros1/raw_cloud.h"

namespace isthmus::ros1 {
namespace {

TEST(Ros1ScanQueue, DropsTheOldestWhenFull) {
  ScanQueue queue(2);
  EXPECT_TRUE(queue.Add("a", 1));
  EXPECT_TRUE(queue.Add("b", 2));
  EXPECT_FALSE(queue.Add("c", 3));
  EXPECT_EQ(queue.dropped(), 1U);
  queue.Close();
  EXPECT_EQ(queue.Take()->bytes, "b");
  EXPECT_EQ(queue.Take()->bytes, "c");
  EXPECT_FALSE(queue.Take().has_value());
}

// Clouds as roscpp would receive them are read as those of a bag.
TEST(Ros1ScanQueue, CloudsAreReadAsThoseOfABag) {
  sensor_msgs::PointCloud2 cloud;
  cloud.header.stamp = ros::Time(12, 500);
  cloud.header.frame_id = "lidar";
  const char* const names[] = {"x", "y", "z"};
  for (uint32_t i = 0; i < 3; ++i) {
    sensor_msgs::PointField& field = cloud.fields.emplace_back();
    field.name = names[i];
    field.offset = 4 * i;
    field.datatype = sensor_msgs::PointField::FLOAT32;
    field.count = 1;
  }
  cloud.height = 1;
  cloud.width = 2;
  cloud.point_step = 12;
  cloud.row_step = 24;
  cloud.data.resize(24);
  ros::SerializedMessage wire = ros::serialization::serializeMessage(cloud);
  RawCloud raw;
  ros::serialization::deserializeMessage(wire, raw);

  ScanQueue queue(5);
  queue.Add("not a cloud", 1);
  queue.Add(raw.bytes, 2);
  queue.Close();
  const auto reader = ReadQueue(queue, "points", {});
  EXPECT_EQ(reader->Next().status().code(), absl::StatusCode::kInvalidArgument);
  const auto scan = reader->Next();
  ASSERT_TRUE(scan.ok()) << scan.status();
  ASSERT_TRUE(scan->has_value());
  EXPECT_EQ((*scan)->end_stamp_ns, 12'000'000'500);
  EXPECT_EQ((*scan)->payload.width, 2U);
  EXPECT_FALSE(reader->Next()->has_value());
}

}  // namespace
}  // namespace isthmus::ros1
