#include "lab/bench/merging/own_loops.h"

#include <memory>
#include <utility>

#include "server/pipeline.h"
#include "storage/memory_store.h"

namespace isthmus::bench {

absl::Status FindOwnLoops(const server::PipelineOptions& options, DrivenRobot* robot) {
  auto store = storage::MakeMemoryStore();
  const storage::MapStore& records = *store;
  const auto pipeline = server::Pipeline::Open(options, std::move(store));
  if (!pipeline.ok()) return pipeline.status();
  const auto session =
      (*pipeline)->sessions().Create({robot->session.robot, robot->session.sensor});
  if (!session.ok()) return session.status();
  for (const auto& submap : robot->submaps) {
    Submap named = *submap;
    named.id.session = session->record.id;
    const auto added = (*pipeline)->sessions().AddSubmap(named);
    if (!added.ok()) return added.status();
    (*pipeline)->WaitUntilIdle();
  }
  auto loops = records.ListLoops();
  if (!loops.ok()) return loops.status();
  robot->loops = *std::move(loops);
  return absl::OkStatus();
}

}  // namespace isthmus::bench
