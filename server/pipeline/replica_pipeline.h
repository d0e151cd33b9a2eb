// The pipeline of a server that only reads its map, and follows the server that has it.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "server/pipeline/reading_pipeline.h"
#include "server/threads/follower_thread.h"
#include "storage/map_follower.h"

namespace isthmus::server {

// Matches nothing, makes no revisions and takes nothing in: it composes the map as the other server
// has placed it. Every change is refused.
class ReplicaPipeline : public ReadingPipeline {
 public:
  ReplicaPipeline(const PipelineOptions& options, std::unique_ptr<storage::MapStore> store,
                  std::unique_ptr<storage::MapFollower> follower, const Clock& clock);
  ~ReplicaPipeline() override;

  // Reads all of the map and starts the threads. Call once.
  absl::Status Start();

  absl::Status CheckTakesChanges() const override;
  MapInfo GetMapInfo() override;
  ServerLoad GetLoad() override;
  void WaitUntilIdle() override;
  void StopTaking() override {}
  void Shutdown() override;

 private:
  // The places of robots that moved since the server started, at their newest scan that is stored.
  std::vector<RobotPlace> MappingPlaces() const override;

  FollowerThread follower_;
  // The scan that each session's trajectory ended with when the server started.
  std::map<SessionId, uint64_t> at_start_;
};

}  // namespace isthmus::server
