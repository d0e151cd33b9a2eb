// The ways of all sessions in a map, put together from several answers about a map that may change
// between them.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <vector>

#include "core/map/session.h"
#include "core/map/track.h"
#include "core/records/map_info.h"
#include "core/records/map_reading.h"

namespace isthmus {

// The questions that are asked. Each may be answered at another revision.
struct TrackSource {
  std::function<absl::StatusOr<MapInfo>()> map_info;
  // All sessions in order of creation, segments among them.
  std::function<absl::StatusOr<std::vector<SessionRecord>>()> sessions;
  // In the map frame, of a segment of the session that a robot opened.
  std::function<absl::StatusOr<RobotTrajectory>(const SessionId& opened, uint32_t segment)>
      trajectory;
};

// The name that goes on meaning the map that is meant now: its reference. NotFound as NumberIn; of
// no maps, 0 stays.
absl::StatusOr<MapName> StableName(const MapInfo& info, const MapName& map);

// Every session that lies in the map, or of that robot alone, in order of creation; of a session
// the segments that lie in it. All are in one frame, whatever becomes of the map's number
// meanwhile: where maps join or part, all is asked again. `info` is what is known of the map by
// now. NotFound for a map, or robot that is named and unknown; FailedPrecondition, naming its map,
// where the robot is in another one; Aborted where the map does not stand still for as long as it
// takes.
absl::StatusOr<std::vector<Track>> ReadTracks(const TrackSource& source, MapInfo info,
                                              const MapName& map, const RobotId& robot = {});

// The way of each robot's newest session, in order of `robots`; empty for a robot without tracks.
std::vector<Trajectory> NewestWays(std::vector<Track> tracks, const std::vector<RobotId>& robots);

}  // namespace isthmus
