// The merged map as a file to download: GET /export/map.pcd, .ply, .bt, .ot.
#pragma once

#include <grpcpp/channel.h>

#include <memory>

#include "server/http/exchange.h"
#include "server/web/stream_slots.h"

namespace isthmus::web {

// ?component=, ?resolution= (m) and ?box=minx,miny,minz,maxx,maxy,maxz (m, map frame) as in
// ExportMapRequest. A file that cannot be sent to its end ends in a broken connection. `slots` must
// outlive the answer.
http::Response AnswerMapFile(const http::Request& request,
                             const std::shared_ptr<grpc::Channel>& channel, StreamSlots* slots);

}  // namespace isthmus::web
