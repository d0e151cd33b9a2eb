// The ways of robots in the map's frame.
#pragma once

#include <absl/status/statusor.h>

#include <Eigen/Core>
#include <vector>

#include "client/library/client.h"
#include "core/ids.h"
#include "core/map/track.h"

namespace isthmus::exports {

// Every session of all robots that lies in the map, or of that robot alone, in order of creation.
// Sessions that are not placed, and segments in other maps, are left out; NotFound for a map or
// robot that is named and unknown.
absl::StatusOr<std::vector<Track>> ReadTracks(client::Client& client, const MapName& map,
                                              const RobotId& robot);

// Where sensors were along the tracks, at least kStationM of way apart. Map frame.
absl::StatusOr<std::vector<Eigen::Vector3d>> ReadStations(client::Client& client,
                                                          const MapName& map, const RobotId& robot);

}  // namespace isthmus::exports
