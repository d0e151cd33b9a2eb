// Tiles of the map as browsers load them: GET /tiles/MAP/LEVEL/X/Y.pts.
#pragma once

#include <grpcpp/channel.h>

#include <memory>

#include "server/http/exchange.h"

namespace isthmus::web {

// Its points as PTS2 (docs/storage-format.md), with its version as ETag, so that a client that has
// that one hears 304; `Isthmus-Revision`, of the map that was read; and `Isthmus-Robots`, a JSON
// array of the names that the points index.
http::Response AnswerTile(const http::Request& request,
                          const std::shared_ptr<grpc::Channel>& channel);

}  // namespace isthmus::web
