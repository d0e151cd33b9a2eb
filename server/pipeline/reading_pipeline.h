// The reading half of the pipeline: the answers that are the same whether this server changes the
// map or follows another one that does.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/concurrency/executor.h"
#include "server/localisation/localisation_maps.h"
#include "server/localisation/localising_robots.h"
#include "server/pipeline.h"
#include "server/pipeline/map_decisions.h"
#include "server/pipeline/map_watch.h"
#include "server/pipeline/pipeline_parts.h"
#include "server/pipeline/session_manager.h"
#include "server/pipeline/view_reader.h"
#include "server/threads/composition_thread.h"
#include "server/threads/placement_thread.h"
#include "server/threads/retention_thread.h"

namespace isthmus::server {

class ReadingPipeline : public Pipeline {
 public:
  Sessions& sessions() override { return sessions_; }
  Decisions& decisions() override { return decisions_; }
  Events& events() override { return parts_.events; }
  const MapReader& reader() const override { return reader_; }
  MapFeed& feed() override { return map_watch_; }
  absl::StatusOr<std::unique_ptr<RobotLocaliser>> OpenLocaliser(
      const LocalisationRequest& request) override;
  MapInfo GetMapInfo() override;
  ServerLoad GetLoad() override;
  absl::StatusOr<std::string> ExportPoseGraph(const MapName& map) override {
    return placement_->WriteG2o(map);
  }
  std::vector<RobotPlace> RobotPlaces() final;

 protected:
  ReadingPipeline(const PipelineOptions& options, std::unique_ptr<storage::MapStore> store,
                  const Clock& clock);

  // The steps of a start that both kinds have, in this order; what they need of the map is there.
  absl::Status OpenParts(std::function<absl::Status(const ingest::RetentionAction&)> act);
  // Null: no revisions are made, see PlacementThread.
  void StartPlacing(storage::MapStore* store);
  void StartComposing();
  // Waits until nothing is under way, or waits, that the view does not show yet, or it is shut
  // down.
  void WaitUntilSettled();
  virtual bool IsSettled(uint64_t pending_scans, const MapView& view) const;
  // The places of the robots that map, in order of their sessions.
  virtual std::vector<RobotPlace> MappingPlaces() const = 0;

  PipelineParts parts_;
  SessionManager sessions_;
  MapDecisions decisions_;
  const ViewReader reader_;
  MapWatch map_watch_;
  // The newest whole map that watchers were told of, which the view shows before.
  std::atomic<int64_t> told_revision_ = 0;
  localisation::LocalisingRobots localising_;
  std::unique_ptr<RetentionThread> retention_;  // The members below tell it.
  // Destroyed in reverse: the executor first, so that none of its tasks outlives the threads.
  std::unique_ptr<CompositionThread> composition_;
  std::unique_ptr<PlacementThread> placement_;
  std::unique_ptr<Executor> executor_;
  std::unique_ptr<localisation::LocalisationMaps> localisation_maps_;  // Uses the executor.

 private:
  // The inputs and the actions of the limits on robots' sessions.
  RetentionThread::Hooks RetentionHooks(
      std::function<absl::Status(const ingest::RetentionAction&)> act);
  void AddSessions(const MapView& view, ServerLoad* load) const;
  DiskLoad GetDiskLoad(const MapView& view, uint64_t spilled_bytes) const;
};

}  // namespace isthmus::server
