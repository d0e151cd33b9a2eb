// A lookup of the robot that a session belongs to.
#pragma once

#include <map>
#include <string>

#include "server/pipeline.h"

namespace isthmus::rpc {

using RobotOfSession = std::map<SessionId, RobotId>;

inline RobotOfSession RobotsOf(server::Pipeline& pipeline) {
  RobotOfSession robots;
  for (const server::SessionStatus& session : pipeline.ListSessions()) {
    robots.emplace(session.record.id, session.record.robot);
  }
  return robots;
}

// Empty for a session that has been deleted in the meantime.
inline std::string RobotOf(const RobotOfSession& robots, const SessionId& session) {
  const auto found = robots.find(session);
  return found == robots.end() ? std::string() : found->second.value();
}

}  // namespace isthmus::rpc
