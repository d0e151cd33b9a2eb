// Submaps of robots with their own SLAM.
#pragma once

#include <absl/status/statusor.h>

#include "core/map/submap.h"
#include "server/ingest/worker_records.h"

namespace isthmus::ingest {

// Checks a submap that came from outside and makes it one like our own: points grouped by keyframe,
// a trajectory entry per keyframe. InvalidArgument when it has no points or keyframes, a point
// names a keyframe that is not there, or numbers are not finite.
absl::StatusOr<FinishedSubmap> MakeUploadedSubmap(Submap submap);

// True if an upload repeats a stored submap, up to the rounding of the store.
bool SameSubmap(const Submap& stored, const Submap& repeated);

}  // namespace isthmus::ingest
