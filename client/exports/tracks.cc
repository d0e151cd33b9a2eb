#include "client/exports/tracks.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "core/floors/floors.h"

namespace isthmus::exports {

absl::StatusOr<std::vector<Track>> ReadTracks(client::Client& client, const MapName& map,
                                              const RobotId& robot) {
  const auto info = client.GetMapInfo();
  if (!info.ok()) return info.status();
  const auto number = NumberIn(*info, map);
  if (!number.ok()) return number.status();
  const auto sessions = client.ListSessions();
  if (!sessions.ok()) return sessions.status();
  std::vector<Track> tracks;
  bool is_known = robot.empty();
  for (const SessionStatus& status : *sessions) {
    const SessionRecord& session = status.record;
    if (session.segment > 1 || (!robot.empty() && session.robot != robot)) continue;
    is_known = true;
    auto trajectory = client.GetTrajectory(RobotId(session.id.value()), TrajectoryFrame::kMap);
    if (absl::IsFailedPrecondition(trajectory.status())) continue;
    if (!trajectory.ok()) return trajectory.status();
    if (trajectory->component != *number) continue;
    tracks.push_back({session.robot, session.id, std::move(trajectory->poses)});
  }
  if (!is_known) {
    return absl::NotFoundError(absl::StrCat("no robot \"", robot.value(), "\" in this map"));
  }
  return tracks;
}

absl::StatusOr<std::vector<Eigen::Vector3d>> ReadStations(client::Client& client,
                                                          const MapName& map,
                                                          const RobotId& robot) {
  const auto tracks = ReadTracks(client, map, robot);
  if (!tracks.ok()) return tracks.status();
  std::vector<Eigen::Vector3d> stations;
  for (const Track& track : *tracks) floors::AddStations(track.poses, &stations);
  return stations;
}

}  // namespace isthmus::exports
