#include "client/report/advice.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include <map>
#include <set>

#include "client/console/console.h"
#include "client/console/tracking_text.h"

namespace isthmus::report {
namespace {

void AddStorage(const ServerState& state, std::vector<Advice>* out) {
  if (!state.info.storage_problem.empty()) {
    out->push_back({absl::StrCat("The store fails: ", state.info.storage_problem),
                    "Make room, or repair the disk or its connection. Robots with a spool keep "
                    "their scans meanwhile, and storing continues by itself."});
  }
  for (const std::string& damaged : state.info.damaged) {
    out->push_back({absl::StrCat("Damaged in the store: ", damaged),
                    "It is left out of the map. Check the disk; a backup may have it whole."});
  }
}

void AddSessions(const ServerState& state, std::vector<Advice>* out) {
  std::map<RobotId, uint64_t> stored;
  std::map<RobotId, uint64_t> quotas;
  for (const SessionStatus& session : state.sessions) {
    const std::string& id = session.record.id.value();
    stored[session.record.robot] += session.map_bytes + session.scan_bytes;
    quotas[session.record.robot] = session.quota_bytes;
    if (!session.archive_problem.empty()) {
      out->push_back({absl::StrCat(id, ": raw scans are missing: ", session.archive_problem),
                      "The map is not touched by this; `isthmus rebuild` will lack them."});
    }
    if (session.record.segment > 1) continue;  // Told with the first.
    if (session.lost_since_ns != 0 && session.record.state == SessionState::kActive) {
      out->push_back({absl::StrFormat("%s is lost since stamp %.3f", id,
                                      1e-9 * static_cast<double>(session.lost_since_ns)),
                      "Drive it slowly, or back to a known place. If it stays lost, it continues "
                      "in a new segment, which is joined like another robot's map."});
    }
    const std::string degenerate = cli::DegeneracyText(session.scans);
    if (!degenerate.empty()) {
      out->push_back({absl::StrCat(id, ": ", degenerate),
                      "Its map may be too long or too short along that direction. Drive where "
                      "walls or poles stand across the way."});
    }
  }
  for (const auto& [robot, bytes] : stored) {
    if (quotas[robot] == 0 || bytes <= quotas[robot]) continue;
    out->push_back({absl::StrCat(robot.value(), " has stored ", cli::HumanBytes(bytes), " of ",
                                 cli::HumanBytes(quotas[robot])),
                    "Raise its quota, or delete sessions that are no longer needed."});
  }
}

// The most probable match between that component and any other.
const MatchEdge* BestMatch(const ServerState& state, const std::set<SessionId>& inside) {
  const MatchEdge* best = nullptr;
  for (const MatchEdge& edge : state.graph.matches) {
    if (inside.contains(edge.match.a) == inside.contains(edge.match.b)) continue;
    if (best == nullptr || edge.match.confidence > best->match.confidence) best = &edge;
  }
  return best;
}

void AddApart(const ServerState& state, std::vector<Advice>* out) {
  for (const Component& component : state.info.components) {
    if (component.component == 0) continue;  // The others are to be joined to it.
    const std::set<SessionId> inside(component.sessions.begin(), component.sessions.end());
    const std::string names = absl::StrJoin(
        component.sessions, ", ",
        [](std::string* text, const SessionId& session) { text->append(session.value()); });
    const MatchEdge* best = BestMatch(state, inside);
    if (best == nullptr) {
      out->push_back({absl::StrCat(names, ": not joined with any other map"),
                      "Nothing was compared with it yet: it is too small, or the server is still "
                      "at work."});
      continue;
    }
    const Match& match = best->match;
    out->push_back(
        {absl::StrCat(names, ": not joined. Closest is ", match.a.value(), " ~ ", match.b.value(),
                      ", ", ToString(match.state), " ", ToString(match.reason), ": ", match.detail),
         WhatToDo(match.reason)});
  }
}

}  // namespace

std::vector<Advice> WhatIsWaiting(const ServerState& state) {
  std::vector<Advice> out;
  AddStorage(state, &out);
  AddSessions(state, &out);
  AddApart(state, &out);
  if (!state.info.settled) {
    out.push_back({"The server is at work: scans, matches or the map are still being computed",
                   "`isthmus status --wait settled` returns when it is done; then report again."});
  }
  return out;
}

const char* WhatToDo(MatchReason reason) {
  switch (reason) {
    case MatchReason::kFreeSpace:
      return "Nothing, if the maps do not overlap. If they do: wait for more, or give the pose "
             "with "
             "`isthmus match set`.";
    case MatchReason::kPossibleTwin:
      return "Drive one robot on into the surroundings, anchor both starts (`isthmus anchor set`), "
             "or use `isthmus match accept` if it is the same place.";
    case MatchReason::kAmbiguous:
      return "Drive where the places differ, or use `isthmus match accept` if the transform found "
             "is right.";
    case MatchReason::kCycle:
      return "Look at the matches that it contradicts; `isthmus match reject` the wrong one.";
    case MatchReason::kDegenerate:
      return "Drive both robots past a corner or a door frame: along the ground that they share "
             "now the maps can slide.";
    case MatchReason::kFewComparisons:
      return "Send the keyframe of each point with uploads, so that free space can be checked.";
    case MatchReason::kStrained:
      return "Wait. If it stays, one robot's odometry was lost on the way: look at its scans.";
    case MatchReason::kByHand:
      return "A person decided so; `isthmus match withdraw` takes it back.";
    case MatchReason::kNoPoses:
      return "Put the trajectory beside the map.";
    case MatchReason::kTooSmall:
      return "Drive both robots past more of the same ground and things (furniture, cars), or "
             "`isthmus match accept` if it is the same place.";
    case MatchReason::kNoCandidate:
    case MatchReason::kLowOverlap:
    case MatchReason::kLoose:
      return "Wait, or drive one robot where the other was; `isthmus match set` if you know the "
             "pose.";
    case MatchReason::kNone:
    case MatchReason::kOk:
    case MatchReason::kGroup:
    case MatchReason::kNotConverged:
    case MatchReason::kUnverified:
      break;
  }
  return "Wait: the server tries again by itself as the maps grow.";
}

}  // namespace isthmus::report
