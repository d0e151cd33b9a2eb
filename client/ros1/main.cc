// isthmus-ros1-bridge: a robot's clouds from ROS to the server, its pose and the map to ROS.
#include <ros/ros.h>

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include "client/readers/messages/decode/message_fields.h"
#include "client/ros1/limits.h"
#include "client/ros1/map_publisher.h"
#include "client/ros1/parameters.h"
#include "client/ros1/pose_publisher.h"
#include "client/ros1/raw_cloud.h"
#include "client/ros1/scan_pusher.h"
#include "client/ros1/scan_queue.h"

namespace isthmus::ros1 {
namespace {

// Everything that one robot needs, from its making to its end.
class RobotBridge {
 public:
  RobotBridge(ros::NodeHandle& node, const Parameters& parameters)
      : poses_(node, parameters.frames),
        queue_(kQueuedScans),
        pusher_(parameters, queue_, [this](const ScanAck& ack) { poses_.OnAck(ack); }),
        thread_([this] { Push(); }),
        subscriber_(node.subscribe<RawCloud>(
            parameters.points, kQueuedScans,
            [this](const boost::shared_ptr<const RawCloud>& cloud) { OnCloud(*cloud); })) {}
  ~RobotBridge() { End().IgnoreError(); }

  // Scans that ROS delivered go to the spool. Returns the error that stopped the pushing, if any.
  absl::Status End() {
    subscriber_.shutdown();
    queue_.Close();
    if (thread_.joinable()) thread_.join();
    return result_;
  }
  PosePublisher& poses() { return poses_; }

 private:
  void OnCloud(const RawCloud& cloud) {
    const auto fields = readers::OpenFields("ros1", cloud.bytes);
    if (fields.ok()) {
      readers::FieldReader reader = *fields;
      poses_.SetSensorFrame(readers::ReadHeader(reader).frame);
    }
    if (!queue_.Add(cloud.bytes, static_cast<int64_t>(ros::Time::now().toNSec()))) {
      ROS_WARN_THROTTLE(kComplaintPeriodS,
                        "%lu scans were dropped: the disk of ~spool is slower than the sensor",
                        queue_.dropped());
    }
  }
  void Push() {
    result_ = pusher_.Run();
    if (result_.ok()) return;
    ROS_FATAL("scans cannot be pushed: %s", std::string(result_.message()).c_str());
    ros::requestShutdown();
  }

  PosePublisher poses_;
  ScanQueue queue_;
  ScanPusher pusher_;
  absl::Status result_;
  std::thread thread_;
  ros::Subscriber subscriber_;
};

int Run(const Parameters& parameters) {
  ros::NodeHandle node;
  std::unique_ptr<RobotBridge> robot;
  MapPublisher::Robot in_map;
  if (!parameters.robot.empty()) {
    robot = std::make_unique<RobotBridge>(node, parameters);
    in_map = {
        [&robot] { return robot->poses().home(); },
        [&robot](std::set<SessionId> sessions) { robot->poses().SetJoined(std::move(sessions)); }};
  }
  {
    const MapPublisher map(node, parameters, in_map);
    ros::AsyncSpinner spinner(2);  // So that a large cloud does not hold up tf.
    spinner.start();
    ros::waitForShutdown();
  }
  return robot == nullptr || robot->End().ok() ? 0 : 1;
}

}  // namespace
}  // namespace isthmus::ros1

int main(int argc, char** argv) {
  ros::init(argc, argv, "isthmus_bridge");
  const auto parameters = isthmus::ros1::ReadParameters(ros::NodeHandle("~"));
  if (!parameters.ok()) {
    ROS_FATAL("%s", std::string(parameters.status().message()).c_str());
    return 2;
  }
  return isthmus::ros1::Run(*parameters);
}
