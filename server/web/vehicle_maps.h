// Maps for vehicles that speak VDA 5050: GET /vda5050/MAP/map.pcd, .ply, .bt, .ot.
#pragma once

#include "server/http/exchange.h"
#include "server/rpc/gate.h"

namespace isthmus::web {

// The action downloadMap (VDA 5050 version 2.1, 6.8.1) for the file as it is now, as JSON: all but
// the actionId, which is its sender's to give. The link has the host that was asked, and the
// query's resolution and box, and names the map by its reference session; it holds for this
// revision of the map alone. MAP is a session in the map, or its number. NotFound for an unknown
// map or file.
http::Response AnswerDownloadMap(const http::Request& request, rpc::Gate& gate);

}  // namespace isthmus::web
