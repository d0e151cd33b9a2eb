// Trajectories as readers get them: the stored part and the part that is not yet, in one frame.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>

#include "server/ingest/session_workers.h"
#include "server/map/map_writer.h"
#include "server/pipeline.h"
#include "storage/map_store.h"

namespace isthmus::server {

// See Pipeline::GetTrajectory.
absl::StatusOr<RobotTrajectory> ReadTrajectory(const MapWriter& map,
                                               const ingest::SessionWorkers& workers,
                                               const storage::MapStore& store, const RobotId& robot,
                                               TrajectoryFrame frame, uint32_t segment);

}  // namespace isthmus::server
