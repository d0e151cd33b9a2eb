// The reading part of the pipeline: questions of people and robots about the map.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <functional>
#include <memory>
#include <optional>
#include <semaphore>
#include <string>
#include <vector>

#include "server/composition/occupancy/kept_occupancy.h"
#include "server/ingest/session_workers.h"
#include "server/map/map_writer.h"
#include "server/map/submap_cache.h"
#include "server/map_reader.h"
#include "storage/map_store.h"

namespace isthmus::server {

absl::Status UnknownRobot(const RobotId& robot);

// See MapReader for the promises. Each answer is made from one view, without a lock.
// Thread safe.
class ViewReader : public MapReader {
 public:
  // Everything must outlive it.
  ViewReader(const MapWriter* map, const storage::MapStore* store, SubmapCache* submaps,
             const ingest::SessionWorkers* workers, const composition::OccupancyOptions& occupancy,
             uint64_t kept_occupancy_bytes);

  std::shared_ptr<const MapView> View() const override { return map_->view(); }
  MapInfo Describe(const MapView& view) const override;
  ListAt<RobotAnchor> ListAnchors(const MapView& view) const override;
  absl::StatusOr<RobotTrajectory> GetTrajectory(const MapView& view, const RobotId& robot,
                                                TrajectoryFrame frame,
                                                uint32_t segment) const override;
  absl::StatusOr<std::vector<Track>> GetTracks(const MapView& view,
                                               const MapName& map) const override;
  absl::StatusOr<FreeSpace> ReadFreeSpace(const MapView& view, const ExportRequest& wanted,
                                          uint64_t max_file_bytes,
                                          const std::function<bool()>& keep_on) const override;

  static MatchEdge Describe(const Match& match, const MapView& view);
  static Loop Describe(const LoopClosure& loop, const MapView& view);

  absl::StatusOr<ListAt<SubmapStatus>> ListSubmaps(
      const std::optional<RobotId>& robot) const override;
  MatchGraph GetMatchGraph() const override;
  absl::StatusOr<ListAt<Loop>> ListLoops(const std::optional<RobotId>& robot) const override;
  absl::StatusOr<std::vector<RevisionInfo>> ListRevisions(int limit) const override;
  absl::StatusOr<RevisionDiff> DiffRevisions(int64_t from, int64_t to) const override;
  absl::StatusOr<ChangeList> FindChanges(const ChangeQuery& query,
                                         const std::function<bool()>& keep_on) const override;
  absl::StatusOr<RobotTransform> GetTransform(const RobotId& a, const RobotId& b) const override;
  absl::Status ExportMap(const ExportRequest& request, const std::function<void(int64_t)>& begin,
                         const std::function<bool(const std::string&)>& sink) const override;

 private:
  // From its making to its end somebody makes a list.
  class Turn {
   public:
    explicit Turn(std::counting_semaphore<>& turns) : turns_(turns) { turns_.acquire(); }
    ~Turn() { turns_.release(); }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    std::counting_semaphore<>& turns_;
  };

  composition::OccupancyOptions OccupancyOf(const ExportRequest& request, uint32_t number,
                                            const std::function<bool()>& keep_on) const;
  absl::Status ExportOccupancy(const MapView& view, const ExportRequest& request, uint32_t number,
                               const std::function<bool(const std::string&)>& sink) const;

  const MapWriter* const map_;
  const storage::MapStore* const store_;
  SubmapCache* const submaps_;
  const ingest::SessionWorkers* const workers_;
  const composition::OccupancyOptions occupancy_;
  mutable composition::KeptOccupancy kept_occupancy_;
  mutable std::counting_semaphore<> turns_;
};

}  // namespace isthmus::server
