#include "tests/faults/harness/room_robot.h"

#include <absl/strings/str_cat.h>

#include <cmath>
#include <utility>

#include "tests/server/rpc/room_scans.h"

namespace isthmus::faults {
namespace {

constexpr int64_t kTurnNs = 100'000'000;

// One of the oval lanes between the pillars; a robot moves at most 0.2 m a scan.
struct Lane {
  double x, y, half_x, half_y, phase, turn_rad;
};
constexpr Lane kLanes[kRobots] = {{9.5, 0.2, 7.5, 0.9, 0.0, 0.3},
                                  {9.0, 0.4, 7.0, 0.7, 1.7, 0.5},
                                  {10.0, 0.1, 8.0, 0.8, 3.1, 0.2},
                                  {8.5, 0.3, 6.5, 1.0, 4.4, 0.4}};
constexpr double kRadPerScan = 0.025;

}  // namespace

std::string RobotName(int robot) { return absl::StrCat("r", robot); }

Pose RobotPose(int robot, uint64_t scan) {
  const Lane& lane = kLanes[robot];
  const double angle = lane.phase + kRadPerScan * static_cast<double>(scan);
  return Pose::FromXyzRpy(lane.x + lane.half_x * std::sin(angle),
                          lane.y + lane.half_y * std::sin(2 * angle), 0, 0, 0,
                          lane.turn_rad * std::sin(3 * angle));
}

PointPayload RobotScan(int robot, uint64_t scan) {
  v1::PointCloud cloud = rpc::RoomCloud(RobotPose(robot, scan - 1), RobotPose(robot, scan));
  PointPayload payload;
  payload.width = cloud.width();
  payload.stride = cloud.stride();
  for (const v1::PointField& field : cloud.fields()) {
    payload.fields.push_back({field.name(), field.offset(), ScalarType::kFloat32});
  }
  payload.data = std::move(*cloud.mutable_data());
  return payload;
}

int64_t RobotStamp(uint64_t scan) { return static_cast<int64_t>(scan) * kTurnNs; }

}  // namespace isthmus::faults
