// Tiles of the merged map and the steps in which it changes, from and to the API's messages.
#pragma once

#include <absl/status/statusor.h>

#include "core/records/map_changes.h"
#include "isthmus/v1/map_service.pb.h"

namespace isthmus::convert {

v1::TileId ToMessage(const TileId& id);
TileId FromMessage(const v1::TileId& id);

v1::TileInfo ToMessage(const TileInfo& info);
TileInfo FromMessage(const v1::TileInfo& info);

v1::SubmapPlace ToMessage(const SubmapPlace& place);
SubmapPlace FromMessage(const v1::SubmapPlace& place);

v1::RobotPlace ToMessage(const RobotPlace& place);
RobotPlace FromMessage(const v1::RobotPlace& place);

// Adds what a part of a step holds to the step that it belongs to.
void AddPart(const v1::WatchMapResponse& part, MapStep* step);

}  // namespace isthmus::convert
