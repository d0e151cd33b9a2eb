// The drives that matches ask for, as programs that steer robots take them.
#pragma once

#include "client/console/json.h"
#include "core/records/map_graph.h"

namespace isthmus::cli {

// {"goals": [{"robot", "goal"}]}: a goal of nav2_msgs/action/NavigateThroughPoses for each drive,
// in the frame "map", which is that of the robot's map.
Json NavigationGoals(const MatchGraph& graph);

// {"orders": [...]}: an order of VDA 5050 (version 2.1, 6.6) for each drive. `manufacturer` and
// `headerId` are its sender's to give. Maps are called by their reference sessions, as by GET
// /vda5050.
Json VehicleOrders(const MatchGraph& graph);

}  // namespace isthmus::cli
