// Names of maps in requests: `map`, in place of `component`.
#pragma once

#include "core/map/map_name.h"

namespace isthmus::convert {

template <typename Request>
void PutMap(const MapName& map, Request& request) {
  if (map.session().empty()) {
    request.set_component(map.number());
  } else {
    request.set_map(map.session().value());
  }
}

template <typename Request>
MapName MapOf(const Request& request) {
  return request.map().empty() ? MapName(request.component()) : MapName(SessionId(request.map()));
}

}  // namespace isthmus::convert
