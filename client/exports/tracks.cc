#include "client/exports/tracks.h"

#include <utility>

#include "core/floors/floors.h"

namespace isthmus::exports {

TrackSource TracksOf(client::Client& client) {
  const auto sessions = [&client]() -> absl::StatusOr<std::vector<SessionRecord>> {
    auto statuses = client.ListSessions();
    if (!statuses.ok()) return statuses.status();
    std::vector<SessionRecord> records;
    for (SessionStatus& status : *statuses) records.push_back(std::move(status.record));
    return records;
  };
  return {[&client] { return client.GetMapInfo(); }, sessions,
          [&client](const SessionId& opened, uint32_t segment) {
            return client.GetTrajectory(RobotId(opened.value()), TrajectoryFrame::kMap, segment);
          }};
}

absl::StatusOr<std::vector<Track>> ReadTracks(client::Client& client, const MapName& map,
                                              const RobotId& robot) {
  auto info = client.GetMapInfo();
  if (!info.ok()) return info.status();
  return isthmus::ReadTracks(TracksOf(client), *std::move(info), map, robot);
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
