// Scans of a VLP-16 in a room with pillars, cast exactly: enough for the odometry to follow.
#pragma once

#include <cstdint>
#include <string>

#include "core/pose.h"
#include "isthmus/v1/session_service.pb.h"

namespace isthmus::rpc {

// One turn of a sensor that moves evenly from one pose to the other meanwhile, each point as
// measured at its own instant. Fields x y z intensity time ring, all float32, RAW.
v1::PointCloud RoomCloud(const Pose& T_room_begin, const Pose& T_room_end);

// The sensor's pose at the END of a scan: it drives through the room at 0.2 m a scan.
Pose RoomPose(uint64_t sequence);

// The whole message; `session` may be empty.
v1::StreamScansRequest RoomScan(const std::string& session, uint64_t sequence);

}  // namespace isthmus::rpc
