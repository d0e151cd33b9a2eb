// Robots that drive through one room for ever, each on its own way.
#pragma once

#include <cstdint>
#include <string>

#include "core/point_payload.h"
#include "core/pose.h"

namespace isthmus::faults {

inline constexpr int kRobots = 4;

// "r0" ... "r3".
std::string RobotName(int robot);

// T_room_sensor at the END of a scan; scans count from 1.
Pose RobotPose(int robot, uint64_t scan);

// The scan of a VLP-16 on that path: the same bytes at every call.
PointPayload RobotScan(int robot, uint64_t scan);

// The stamp of the END of a scan, ten of them a second.
int64_t RobotStamp(uint64_t scan);

}  // namespace isthmus::faults
