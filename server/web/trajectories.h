// The ways of robots as files: GET /trajectories/SESSION.tum, /trajectories.geojson.
#pragma once

#include <grpcpp/channel.h>

#include <memory>

#include "server/http/exchange.h"

namespace isthmus::web {

// SESSION is a session's id, or a robot's name for its newest. In the map frame, with ?frame=odom
// in its own. Errors of MapService.GetTrajectory.
http::Response AnswerTrajectory(const http::Request& request,
                                const std::shared_ptr<grpc::Channel>& channel);

// All ways of a component, ?component= (0), on the Earth: see earth::FormatGeoJson. NotFound for an
// unknown component, FailedPrecondition where the map has no place there.
http::Response AnswerTrajectoriesGeoJson(const http::Request& request,
                                         const std::shared_ptr<grpc::Channel>& channel);

}  // namespace isthmus::web
