// The merged map as Autoware's map loader reads it: GET /autoware/MAP/...
#pragma once

#include "server/http/exchange.h"
#include "server/rpc/gate.h"
#include "server/web/stream_slots.h"

namespace isthmus::web {

// pointcloud_map_metadata.yaml lists the map's tiles as cells, by their lower corners in whole
// metres; pointcloud_map/X_Y.pcd has the points of one, its lower edges included.
// FailedPrecondition where tiles are not whole metres. `slots` must outlive the answer.
http::Response AnswerAutoware(const http::Request& request, rpc::Gate& gate, StreamSlots* slots);

}  // namespace isthmus::web
