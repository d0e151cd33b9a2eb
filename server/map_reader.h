// The reader of the map: what people, robots and pages ask about it.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/map/composed_map.h"
#include "core/map/free_space.h"
#include "core/map/map_name.h"
#include "core/map/revision.h"
#include "core/map/track.h"
#include "core/records/changed_volumes.h"
#include "core/records/list_at.h"
#include "core/records/map_graph.h"
#include "core/records/map_info.h"
#include "core/records/map_reading.h"

namespace isthmus::server {

struct MapView;

// Thread safe. What is asked of one view is of one revision, whatever comes meanwhile.
class MapReader {
 public:
  virtual ~MapReader() = default;

  // The map as it is now; never null.
  virtual std::shared_ptr<const MapView> View() const = 0;
  // The newest composed map; empty map of revision 0 before the first.
  std::shared_ptr<const ComposedMap> Map() const;
  // Without work under way: as Pipeline::GetMapInfo, but for what is not of the view.
  virtual MapInfo Describe(const MapView& view) const = 0;
  virtual ListAt<RobotAnchor> ListAnchors(const MapView& view) const = 0;
  // The trajectory of the session of that id, or else of the robot's newest. In the map frame poses
  // follow the submaps, smoothly from one to the next; behind the newest submap its T_map_odom
  // holds. Segment 0: in odom the last; in the map frame all that are placed in one component, the
  // lowest that has any. NotFound for an unknown robot or segment; FailedPrecondition when frame is
  // kMap and nothing of the trajectory has been placed yet (nothing stored of it).
  virtual absl::StatusOr<RobotTrajectory> GetTrajectory(const MapView& view, const RobotId& robot,
                                                        TrajectoryFrame frame,
                                                        uint32_t segment) const = 0;
  // The same of the newest view.
  absl::StatusOr<RobotTrajectory> GetTrajectory(const RobotId& robot, TrajectoryFrame frame,
                                                uint32_t segment = 0) const {
    return GetTrajectory(*View(), robot, frame, segment);
  }
  // The ways of all sessions that lie in the map, as isthmus::ReadTracks.
  virtual absl::StatusOr<std::vector<Track>> GetTracks(const MapView& view,
                                                       const MapName& map) const = 0;
  // The leaves of the .bt that ExportMap writes; ResourceExhausted where its tree would
  // have more than so many bytes. Cancelled where `keep_on`, asked while rays are cast, says no.
  virtual absl::StatusOr<FreeSpace> ReadFreeSpace(const MapView& view, const ExportRequest& wanted,
                                                  uint64_t max_file_bytes,
                                                  const std::function<bool()>& keep_on) const = 0;

  // The submaps of every session of the robot; of all robots if absent. NotFound for an unknown
  // robot.
  virtual absl::StatusOr<ListAt<SubmapStatus>> ListSubmaps(
      const std::optional<RobotId>& robot) const = 0;
  // Each match as a person's decision on its pair changes it.
  virtual MatchGraph GetMatchGraph() const = 0;
  // Loop closures within sessions of the robot; of all robots when absent. NotFound for an unknown
  // robot.
  virtual absl::StatusOr<ListAt<Loop>> ListLoops(const std::optional<RobotId>& robot) const = 0;
  // The newest at most `limit`, the newest first.
  virtual absl::StatusOr<std::vector<RevisionInfo>> ListRevisions(int limit) const = 0;
  // `to` 0: the latest. OutOfRange when `from` is older than what is kept; NotFound for one that
  // does not exist yet; InvalidArgument when from > to.
  virtual absl::StatusOr<RevisionDiff> DiffRevisions(int64_t from, int64_t to) const = 0;
  // Things that came and went since the query's time or revision. `keep_on` is asked every few
  // milliseconds; Cancelled where it says no. NotFound for a component or revision that does not
  // exist, OutOfRange for a revision that is no longer kept, FailedPrecondition where nothing lies
  // on one of the sides, ResourceExhausted where that is too much for one call.
  virtual absl::StatusOr<ChangeList> FindChanges(const ChangeQuery& query,
                                                 const std::function<bool()>& keep_on) const = 0;
  // Each is a session's id, or else a robot's name. NotFound for an unknown robot;
  // FailedPrecondition when no accepted match connects them; the message says what the best match
  // lacks.
  virtual absl::StatusOr<RobotTransform> GetTransform(const RobotId& a, const RobotId& b) const = 0;
  // Streams the file of the map. NotFound for a component or robot that does not exist. `begin` is
  // told the revision that the file is of, before its first piece. Where a long time passes without
  // a piece, `sink` is asked with an empty one whether to go on.
  virtual absl::Status ExportMap(const ExportRequest& request,
                                 const std::function<void(int64_t revision)>& begin,
                                 const std::function<bool(const std::string&)>& sink) const = 0;
};

}  // namespace isthmus::server
