// The part of the map that an address asks for: ?map= (also called component), ?resolution= (m) and
// ?box=minx,miny,minz,maxx,maxy,maxz (m, map frame).
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <set>

#include "core/map/map_name.h"
#include "isthmus/v1/map_service.pb.h"
#include "server/http/exchange.h"

namespace isthmus::web {

// The largest where none is given.
MapName ReadMapName(const http::Request& request);

// InvalidArgument where the address asks for anything beside these and `site`, or for one twice: a
// client that names an unknown filter would take the whole for a part.
absl::Status CheckQuery(const http::Request& request, std::set<absl::string_view> known);

// Fields that are not given stay as they are; the format must be set. InvalidArgument, saying what
// to give, for all that the call ExportMap refuses itself.
absl::Status ReadMapQuery(const http::Request& request, v1::ExportMapRequest* wanted);

}  // namespace isthmus::web
