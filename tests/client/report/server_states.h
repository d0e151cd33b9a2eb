// States of servers, for tests of what is told of them.
#pragma once

#include "client/report/server_state.h"

namespace isthmus::report {

inline SessionStatus Session(const std::string& robot, uint32_t component) {
  SessionStatus session;
  session.record.id = SessionId(robot + "-1");
  session.record.robot = RobotId(robot);
  session.record.sensor = "vlp16";
  session.record.state = SessionState::kActive;
  session.record.segment = 1;
  session.component = component;
  session.scans.ok = 100;
  return session;
}

// Two robots whose maps are not joined, for that reason.
inline ServerState TwoApart(MatchReason reason, const std::string& a = "alice",
                            const std::string& b = "bob") {
  ServerState state;
  state.address = "box:50051";
  state.info.settled = true;
  state.info.robots = {RobotId(a), RobotId(b)};
  state.sessions = {Session(a, 0), Session(b, 1)};
  for (uint32_t i = 0; i < 2; ++i) {
    const SessionStatus& session = state.sessions[i];
    Component component;
    component.component = i;
    component.reference = session.record.id;
    component.sessions = {session.record.id};
    component.robots = {session.record.robot};
    state.info.components.push_back(component);
    PlacedSession placed;
    placed.placement.session = session.record.id;
    placed.placement.component = i;
    state.graph.placements.push_back(placed);
  }
  MatchEdge edge;
  edge.match.a = state.sessions[0].record.id;
  edge.match.b = state.sessions[1].record.id;
  edge.match.state = MatchState::kNotYet;
  edge.match.reason = reason;
  edge.match.detail = "Only 20 m2 are shared.";
  state.graph.matches = {edge};
  return state;
}

}  // namespace isthmus::report
