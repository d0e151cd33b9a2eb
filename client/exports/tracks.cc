#include "client/exports/tracks.h"

#include <utility>

#include "client/exports/limits.h"

namespace isthmus::exports {

absl::StatusOr<std::vector<Track>> ReadTracks(client::Client& client, uint32_t component,
                                              const RobotId& robot) {
  std::vector<RobotId> robots{robot};
  if (robot.empty()) {
    const auto info = client.GetMapInfo();
    if (!info.ok()) return info.status();
    robots = info->robots;
  }
  std::vector<Track> tracks;
  for (const RobotId& name : robots) {
    auto trajectory = client.GetTrajectory(name, TrajectoryFrame::kMap);
    if (absl::IsFailedPrecondition(trajectory.status())) continue;
    if (!trajectory.ok()) return trajectory.status();
    if (trajectory->component != component) continue;
    tracks.push_back({name, trajectory->session, std::move(trajectory->poses)});
  }
  return tracks;
}

absl::StatusOr<std::vector<Eigen::Vector3d>> ReadStations(client::Client& client,
                                                          uint32_t component,
                                                          const RobotId& robot) {
  const auto tracks = ReadTracks(client, component, robot);
  if (!tracks.ok()) return tracks.status();
  const auto submaps = client.ListSubmaps(robot);
  if (!submaps.ok()) return submaps.status();
  std::vector<Eigen::Vector3d> stations;
  for (const Track& track : *tracks) {
    const Eigen::Vector3d* last = nullptr;
    for (const StampedPose& pose : track.poses) {
      const Eigen::Vector3d& at = pose.pose.translation();
      if (last != nullptr && (at - *last).norm() < kStationM) continue;
      stations.push_back(at);
      last = &at;
    }
  }
  for (const SubmapStatus& submap : *submaps) {
    if (submap.component == component) stations.push_back(submap.T_map_submap.translation());
  }
  return stations;
}

}  // namespace isthmus::exports
