// The bridge as a robot runs it: a roscore, a server that is killed, and what arrives.
#include <absl/strings/str_cat.h>
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <signal.h>
#include <sys/socket.h>
#include <tf2_msgs/TFMessage.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>
#include <unistd.h>
#include <visualization_msgs/MarkerArray.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "client/library/client.h"
#include "client/ros1/conversions.h"
#include "tests/faults/harness/room_robot.h"
#include "tests/faults/harness/server_process.h"

namespace isthmus::ros1 {
namespace {

int FreePort() {
  const int socket_fd = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  bind(socket_fd, reinterpret_cast<sockaddr*>(&address), size);
  getsockname(socket_fd, reinterpret_cast<sockaddr*>(&address), &size);
  close(socket_fd);
  return ntohs(address.sin_port);
}

sensor_msgs::PointCloud2 CloudOf(uint64_t scan) {
  PointPayload payload = faults::RobotScan(0, scan);
  sensor_msgs::PointCloud2 cloud;
  cloud.header.stamp = ToTime(faults::RobotStamp(scan));
  cloud.header.frame_id = "lidar";
  for (const PointField& field : payload.fields) {
    sensor_msgs::PointField& ours = cloud.fields.emplace_back();
    ours.name = field.name;
    ours.offset = field.offset;
    ours.datatype = static_cast<uint8_t>(field.type);
    ours.count = field.count;
  }
  cloud.height = payload.height;
  cloud.width = payload.width;
  cloud.point_step = payload.stride;
  cloud.row_step = payload.stride * payload.width;
  cloud.data.assign(payload.data.begin(), payload.data.end());
  return cloud;
}

// Asked to end, a roscore takes its master with it; killed it would leave it behind.
class EndOfCore {
 public:
  explicit EndOfCore(ChildProcess& core) : core_(core) {}
  ~EndOfCore() {
    ros::shutdown();
    core_.Signal(SIGINT);
    core_.Wait();
  }

 private:
  ChildProcess& core_;
};

// Calls back until it holds; false after half a minute.
bool SpinUntil(const std::function<bool()>& holds) {
  const ros::WallTime deadline = ros::WallTime::now() + ros::WallDuration(30);
  while (!holds() && ros::WallTime::now() < deadline) {
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.1));
  }
  return holds();
}

TEST(Ros1Bridge, EveryScanArrivesThoughTheServerIsKilled) {
  const std::string folder = absl::StrCat(testing::TempDir(), "/ros1_", getpid());
  std::filesystem::create_directories(folder);
  const std::string port = std::to_string(FreePort());
  setenv("ROS_MASTER_URI", absl::StrCat("http://127.0.0.1:", port).c_str(), 1);
  setenv("ROS_IP", "127.0.0.1", 1);
  setenv("ROS_HOME", folder.c_str(), 1);
  setenv("PATH", absl::StrCat("/usr/bin:", std::getenv("PATH")).c_str(), 1);
  ChildProcess core("/usr/bin/roscore", {"-p", port}, folder + "/roscore.log");
  const EndOfCore end_of_core(core);
  std::string line;
  do {
    line = core.ReadLine();
    ASSERT_FALSE(line.empty() && kill(core.pid(), 0) != 0) << core.Errors();
  } while (line.find("started core service") == std::string::npos);

  int argc = 0;
  ros::init(argc, nullptr, "bridge_test", ros::init_options::NoSigintHandler);
  ros::NodeHandle node;
  faults::ServerProcess server(ISTHMUS_SERVER, folder + "/server");
  ASSERT_TRUE(server.Start());
  ChildProcess bridge(
      ISTHMUS_BRIDGE,
      {absl::StrCat("_server:=", server.address()), "_robot:=alice",
       absl::StrCat("_spool:=", folder, "/spool"), "_map_period:=0.2", "_finish:=true"},
      folder + "/bridge.log");

  std::vector<nav_msgs::Odometry> odometry;
  const ros::Subscriber odometry_subscriber = node.subscribe<nav_msgs::Odometry>(
      "odometry", 1000, [&](const nav_msgs::OdometryConstPtr& got) { odometry.push_back(*got); });
  const ros::Publisher mounting = node.advertise<tf2_msgs::TFMessage>("/tf_static", 1, true);
  tf2_msgs::TFMessage where;
  where.transforms = {
      MakeTransform(ros::Time(0), "base_link", "lidar", Pose(Eigen::Vector3d(0, 0, 1)))};
  mounting.publish(where);
  tf2_ros::Buffer tree(ros::Duration(1000));
  const tf2_ros::TransformListener listener(tree);
  const ros::Publisher points = node.advertise<sensor_msgs::PointCloud2>("points", 100);
  ASSERT_TRUE(SpinUntil([&] {
    // The tree of the bridge and ours.
    return points.getNumSubscribers() > 0 && odometry_subscriber.getNumPublishers() > 0 &&
           mounting.getNumSubscribers() >= 2;
  })) << bridge.Errors();

  uint64_t scan = 0;
  const auto publish = [&](int count) {
    for (int i = 0; i < count; ++i) points.publish(CloudOf(++scan));
  };
  const auto all_came = [&] { return odometry.size() == scan; };
  for (int i = 0; i < 3; ++i) {
    publish(10);
    ASSERT_TRUE(SpinUntil(all_came)) << odometry.size() << "\n" << bridge.Errors();
  }
  server.Kill();
  publish(10);
  ASSERT_TRUE(server.Start());
  publish(5);
  ASSERT_TRUE(SpinUntil(all_came)) << odometry.size() << " of " << scan << "\n" << bridge.Errors();
  for (size_t i = 0; i < odometry.size(); ++i) {
    // The END is that of the latest return, a little before that of the turn.
    ASSERT_NEAR((odometry[i].header.stamp - ToTime(faults::RobotStamp(i + 1))).toSec(), 0, 0.001);
    EXPECT_EQ(odometry[i].header.frame_id, "odom");
    EXPECT_EQ(odometry[i].child_frame_id, "base_link");
  }
  // The path is the robot's.
  const Pose truth = faults::RobotPose(0, 1).Inverse() * faults::RobotPose(0, scan);
  const auto& first = odometry.front().pose.pose.position;
  const auto& last = odometry.back().pose.pose.position;
  EXPECT_NEAR(std::hypot(last.x - first.x, last.y - first.y), truth.translation().norm(), 0.3);
  const ros::Time newest = odometry.back().header.stamp;
  EXPECT_TRUE(SpinUntil([&] { return tree.canTransform("map", "base_link", newest); }));

  // Latched: late subscribers get them, too.
  sensor_msgs::PointCloud2 map;
  visualization_msgs::MarkerArray graph;
  const ros::Subscriber late_map = node.subscribe<sensor_msgs::PointCloud2>(
      "map", 1, [&](const sensor_msgs::PointCloud2ConstPtr& got) { map = *got; });
  const ros::Subscriber late_graph = node.subscribe<visualization_msgs::MarkerArray>(
      "match_graph", 1, [&](const visualization_msgs::MarkerArrayConstPtr& got) { graph = *got; });
  EXPECT_TRUE(SpinUntil([&] { return map.width > 100 && graph.markers.size() >= 3; }));
  EXPECT_EQ(map.header.frame_id, "map");

  bridge.Signal(SIGINT);
  EXPECT_EQ(bridge.Wait(), 0) << bridge.Errors();
  auto client = client::Client::Connect({.address = server.address()});
  ASSERT_TRUE(client.ok());
  const auto sessions = (*client)->ListSessions();
  ASSERT_TRUE(sessions.ok());
  ASSERT_EQ(sessions->size(), 1U);
  EXPECT_EQ(sessions->front().last_sequence, scan);
  EXPECT_EQ(sessions->front().record.state, SessionState::kFinished);
  server.Kill();
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace isthmus::ros1
