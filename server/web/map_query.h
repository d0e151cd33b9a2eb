// The part of the map that an address asks for: ?component=, ?resolution= (m) and
// ?box=minx,miny,minz,maxx,maxy,maxz (m, map frame).
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <set>

#include "isthmus/v1/map_service.pb.h"
#include "server/http/exchange.h"

namespace isthmus::web {

// 0 where none is given. InvalidArgument for what is no number.
absl::StatusOr<uint32_t> ReadComponent(const http::Request& request);
absl::Status NoSuchComponent(uint32_t component);

// InvalidArgument where the address asks for anything beside these and `site`, or for one twice:
// who names a filter that there is not would take the whole for a part.
absl::Status CheckQuery(const http::Request& request, const std::set<absl::string_view>& known);

// What is not given is left as it is. InvalidArgument, saying what to give.
absl::Status ReadMapQuery(const http::Request& request, v1::ExportMapRequest* wanted);

}  // namespace isthmus::web
