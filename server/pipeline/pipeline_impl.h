// The pipeline that has the map: wires the parts together. See server/pipeline.h for the promises.
#pragma once

#include <memory>
#include <vector>

#include "core/concurrency/executor.h"
#include "server/pipeline/reading_pipeline.h"
#include "server/threads/matching_thread.h"
#include "server/threads/store_retry_thread.h"

namespace isthmus::server {

class PipelineImpl : public ReadingPipeline {
 public:
  PipelineImpl(const PipelineOptions& options, std::unique_ptr<storage::MapStore> store,
               const Clock& clock);
  ~PipelineImpl() override;

  // Loads the store and starts the threads. Call once.
  absl::Status Start();

  ServerLoad GetLoad() override;
  void WaitUntilIdle() override;
  void StopTaking() override;
  void Shutdown() override;

 private:
  bool IsSettled(uint64_t pending_scans, const MapView& view) const override;
  std::vector<RobotPlace> MappingPlaces() const override;

  std::unique_ptr<MatchingThread> matching_;
  std::unique_ptr<Executor> storing_;  // Is given work by the executor's.
  std::unique_ptr<StoreRetryThread> store_retries_;
};

}  // namespace isthmus::server
