// The ways of robots in the map's frame.
#pragma once

#include <absl/status/statusor.h>

#include <Eigen/Core>
#include <vector>

#include "client/library/client.h"
#include "core/ids.h"
#include "core/map/track.h"
#include "core/records/map_tracks.h"

namespace isthmus::exports {

// The questions of isthmus::ReadTracks, put to the server. The client must outlive it.
TrackSource TracksOf(client::Client& client);

// isthmus::ReadTracks of what the server has.
absl::StatusOr<std::vector<Track>> ReadTracks(client::Client& client, const MapName& map,
                                              const RobotId& robot);

// Sensor positions along the tracks, at least kStationM of way apart. Map frame.
absl::StatusOr<std::vector<Eigen::Vector3d>> ReadStations(client::Client& client,
                                                          const MapName& map, const RobotId& robot);

}  // namespace isthmus::exports
