// The merged map as a file to download: GET /export/map.pcd, .ply, .bt, .ot.
#pragma once

#include <grpcpp/channel.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "isthmus/v1/map_service.pb.h"
#include "server/http/exchange.h"
#include "server/rpc/gate.h"
#include "server/web/stream_slots.h"

namespace isthmus::web {

// ?component=, ?resolution= (m) and ?box=minx,miny,minz,maxx,maxy,maxz (m, map frame) as in
// ExportMapRequest. With ?revision= Aborted where the map has another one by now, and Unavailable
// while submaps wait to be composed; the file's is told in the headers. A file that cannot be sent
// to its end ends in a broken connection. `slots` must outlive the answer.
http::Response AnswerMapFile(const http::Request& request, rpc::Gate& gate,
                             const std::shared_ptr<grpc::Channel>& channel, StreamSlots* slots);

// The format of a file of the map by its name ("map.pcd"); absent for other names.
std::optional<v1::ExportMapRequest::Format> MapFileFormat(absl::string_view name);

// The head of an answer that is to be saved under the name, of that revision of the map.
http::Response FileAnswer(const std::string& name, int64_t revision);

}  // namespace isthmus::web
