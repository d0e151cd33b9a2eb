// A session as it is stored and reported.
#pragma once

#include <cstdint>
#include <string>

#include "core/ids.h"
#include "core/pose.h"

namespace isthmus {

enum class SessionState {
  kActive,    // Takes scans and submaps.
  kFinished,  // Closed by the robot; its map stays.
};

struct SessionRecord {
  SessionId id;
  RobotId robot;
  std::string sensor;  // Name of a sensor model, e.g. "vlp16".
  // Which odometry: "continuous", "floam" or "aloam"; empty: the server's own choice.
  std::string odometry;
  Pose T_base_sensor;  // Extrinsic; identity unless given.
  SessionState state = SessionState::kActive;
  int64_t created_ns = 0;
  int64_t finished_ns = 0;  // 0 while active.
  // Chosen by the client, so that asking twice opens one session; empty: none.
  std::string request_id = {};
};

}  // namespace isthmus
