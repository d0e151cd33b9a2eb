// The ways of robots as files: GET /trajectories/SESSION.tum, /trajectories.geojson.
#pragma once

#include "server/http/exchange.h"
#include "server/rpc/gate.h"

namespace isthmus::web {

// SESSION is a session's id, or a robot's name for its newest. In the map frame, with ?frame=odom
// in its own. Errors of MapService.GetTrajectory.
http::Response AnswerTrajectory(const http::Request& request, rpc::Gate& gate);

// All ways of a component, ?component= (0), on the Earth: see earth::FormatGeoJson. NotFound for an
// unknown component, FailedPrecondition where the map has no place there.
http::Response AnswerTrajectoriesGeoJson(const http::Request& request, rpc::Gate& gate);

}  // namespace isthmus::web
